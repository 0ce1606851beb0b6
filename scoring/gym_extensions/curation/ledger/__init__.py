"""The ledger: which submissions were accepted, with what evidence, and what happened to them since."""
