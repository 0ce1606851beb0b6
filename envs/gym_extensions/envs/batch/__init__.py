"""What vector environments of all bodies share: seeds, time limits, autoreset, infos, saved states."""
