"""What changed: releases from the changelog, entries from the ledger, and both as a feed."""
