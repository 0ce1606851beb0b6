"""What only the makers of this repository run; README.md lists the commands. The package never imports it."""
