"""The claims of the paper, each judged by the experiment."""
