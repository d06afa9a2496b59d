"""What a log says: recording, metrics, figures, report, replay."""
