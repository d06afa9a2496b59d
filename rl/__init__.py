"""One policy for every gait: simulated robot, task, learning, judging, experiments, films, viewer."""
