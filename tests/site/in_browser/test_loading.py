"""Every kind of page loads without a message, an error or a request to another host.

Most kinds are marked ``slow``; ``make browser`` runs them.
"""

import pytest

from .made_site import KINDS, PAGES, Page


def reports(page: Page, folder: str, path: str) -> list[str]:
    """What a page logs, what fails, and what it requests outside of the folder."""
    lines: list[str] = []
    page.on("console", lambda message: lines.append(f"console: {message.text}"))
    page.on("pageerror", lambda error: lines.append(f"error: {error}"))
    page.on("requestfailed", lambda request: lines.append(f"failed: {request.url}"))
    page.on("response", lambda reply: lines.append(f"status: {reply.url}") if reply.status >= 400 else None)
    page.on(
        "request",
        lambda request: (
            lines.append(f"outside: {request.url}") if not request.url.startswith((folder, "data:")) else None
        ),
    )
    page.goto(folder + path, wait_until="load")
    assert page.title().endswith("· gym-extensions")
    return lines


@pytest.mark.parametrize("path", KINDS)
def test_a_page_loads_from_a_file_without_a_message(page: Page, address: str, path: str) -> None:
    assert reports(page, address, path) == []


@pytest.mark.parametrize("kind", ["overview", "submission"])
def test_a_page_loads_below_a_path_of_a_server(page: Page, http_address: str, kind: str) -> None:
    assert reports(page, http_address, PAGES[kind]) == []


def test_these_tests_report_a_request_to_another_host(page: Page, address: str) -> None:
    page.goto(f"{address}index.html")
    lines = reports(page, f"{address}groups/", "hopper-gravity-v0.html")
    assert any(line.startswith("outside: ") for line in lines)
