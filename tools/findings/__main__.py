"""``make findings``: writes both pages and their figures from the committed submissions."""

from __future__ import annotations

from tools.findings import findings, reproduction

if __name__ == "__main__":
    findings.main()
    reproduction.main()
