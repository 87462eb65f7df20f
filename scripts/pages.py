"""What the site has beyond the files of docs/: the commands, the interfaces and the notebooks; a hook of mkdocs."""

from __future__ import annotations

import argparse
import logging
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).parent))
import docstrings

ROOT = Path(__file__).parents[1]
log = logging.getLogger("mkdocs.hooks.pages")


def on_config(config: MkDocsConfig) -> None:
    """Complete the navigation: the pages of the interfaces, and the notebooks where there are any."""
    for section in config.nav or []:
        if isinstance(section, dict) and "API" in section:
            section["API"] = [f"generated/{name}" for name, _ in interfaces()]
    notebooks = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
    if config.nav and notebooks:
        config.nav.insert(4, {"Notebooks": [f"notebooks/{path.name}" for path in notebooks]})


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made from the code, and the reports of the shipped campaigns that lie in reports/."""
    for name, text in [("commands.md", commands()), *interfaces()]:
        files.append(File.generated(config, f"generated/{name}", content=text))
    for path in (*ROOT.glob("campaigns/*/campaign.yaml"), *ROOT.glob("reports/*/report.html")):
        files.append(File.generated(config, _place(path), abs_src_path=str(path)))
    worker = ROOT / "scripts" / "iframe-worker.js"
    files.append(File.generated(config, f"assets/{worker.name}", abs_src_path=str(worker)))
    return files


def on_page_markdown(markdown: str, page: Page, files: Files, **_: object) -> str:
    """Link the gallery with the campaign files, and with those reports that were made."""
    if page.file.src_uri != "gallery.md":
        return markdown
    linked = re.sub(r"`(campaigns/[\w-]+)`", r"[`\1`](\1.yaml)", markdown)
    return re.sub(
        r"!\[[^]]*\]\(gallery/([\w-]+)\.png\)",
        lambda match: (
            f"[{match[0]}]({place})" if files.get_file_from_path(place := f"reports/{match[1]}.html") else match[0]
        ),
        linked,
    )


def on_post_page(output: str, page: Page, **_: object) -> None:
    """Warn of what a page would fetch from a network, which it has to work without; `make site` ends with an error."""
    for address in re.findall(r'(?:\bsrc|<link[^>]*\bhref)="(https?:[^"]*)"', output):
        log.warning("%s fetches %s", page.file.src_uri, address)


def _place(path: Path) -> str:
    """Where a file of a campaign or a report stands on the site: `campaigns/tapes.yaml`, `reports/tapes.html`."""
    return f"{path.parents[1].name}/{path.parent.name}{path.suffix}"


def commands() -> str:
    """Every command with its help, as the terminal shows it."""
    from metrology.cli import parser as of_metrology

    os.environ["COLUMNS"] = "100"
    parts = ["# Commands", "", "`metrology COMMAND --help` prints the same.", ""]
    for name, text, parser in _commands(of_metrology()):
        parts += [
            f"## `metrology {name}`",
            "",
            f"{text[0].upper()}{text[1:]}.",
            "",
            "```text",
            parser.format_help(),
            "```",
        ]
    return "\n".join(parts)


def _commands(parser: argparse.ArgumentParser, before: str = "") -> Iterator[tuple[str, str, argparse.ArgumentParser]]:
    """Name, sentence and parser of each command, and of those within it."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            said = {choice.dest: choice.help or choice.dest for choice in action._choices_actions}
            for name, inner in action.choices.items():
                yield f"{before}{name}", said.get(name, name), inner
                yield from _commands(inner, f"{before}{name} ")


def interfaces() -> list[tuple[str, str]]:
    """Name and text of the pages of the interfaces: the public names, then what each package of the engine offers."""
    pages: dict[str, list[str]] = {}
    for name in docstrings.public():
        pages.setdefault(name.split(".")[1] if name.count(".") > 1 else "metrology", []).append(name)
    return [(f"{package}.md", _page(package, names)) for package, names in pages.items()]


def _page(package: str, names: list[str]) -> str:
    title = "metrology" if package == "metrology" else f"metrology.{package}"
    said = _first_line(title)
    return "\n\n".join([f"# `{title}`", said, *(f"::: {name}" for name in names)])


def _first_line(module: str) -> Any:
    from importlib import import_module

    return (import_module(module).__doc__ or "").split("\n\n")[0]
