"""Bodies that move: Watch shows recorded episodes, Play runs published policies in the browser."""
