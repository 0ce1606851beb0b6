"""Shows and logs the progress of training, as events arrive."""
