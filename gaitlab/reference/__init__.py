"""Published results, as printed, to set beside simulated ones; see the README beside this file."""
