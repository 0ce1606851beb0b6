"""Policies: plain arrays or ONNX networks, their conversion, and the files of a run that contain them."""
