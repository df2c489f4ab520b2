"""The pages that MkDocs makes a site of: docs/, README.md, and a page for each model with its live
page, its equations, what docs/dev/results/models.md says of it, its charts and its text.

    python tools/site/pages.py     writes build/site-pages and build/site.yml; `make site` goes on

Links to files of the repository that are no page become pages of their text.
"""

from __future__ import annotations

import json
import os
import posixpath
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from html import escape
from pathlib import Path

import yaml

from pkgen.compiler import compile_model
from pkgen.explain.scenes import scene_shown
from pkgen.front.read import read
from pkgen_pages.explain.html import fragment
from pkgen_pages.explain.style import style

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGES = ROOT / "build/site-pages"
FOLDERS = {
    "": "The first",
    "particles": "Particles",
    "pendulums": "Pendulums",
    "bodies": "Rigid bodies",
    "constrained": "Constraints and rolling",
    "chains": "Chains",
}
# In this order; a page that is in none goes to the last.
SECTIONS = {
    "Tutorial": ("tutorial", "guide", "cheatsheet", "robots", "web", "plot", "pages", "film"),
    "Reference": (
        *("language", "commands", "editor", "python", "bodies", "rotations", "events", "families"),
        *("control", "reductions", "accuracy", "peers", "enclose", "maps", "diagnostics"),
        *("own-methods", "checkpoints", "embedding", "install"),
    ),
    "Background": (),
}
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
SECTION = re.compile(r"^(#{2,3}) (.*)$", re.MULTILINE)


def models() -> list[Path]:
    return sorted((ROOT / "models").rglob("*.lag"))


def texts() -> list[Path]:
    return sorted([*ROOT.glob("docs/**/*.md"), *ROOT.glob("addons/*/*.md")])


def main() -> int:
    shutil.rmtree(PAGES, ignore_errors=True)
    for folder in ("assets", "live", "models", "files"):
        (PAGES / folder).mkdir(parents=True)
    shutil.copytree(ROOT / "docs/pictures", PAGES / "pictures")
    (PAGES / "assets/explained.css").write_text(style(), encoding="utf-8")
    for file in ("site.css", "site.js", "iframe-worker/iframe-worker.js"):
        shutil.copy(HERE / file, PAGES / "assets")
    for path in texts():
        place = path.relative_to(ROOT).as_posix()
        text = linked(
            path.read_text("utf-8"), posixpath.dirname(place), posixpath.dirname(page_of(place))
        )
        (PAGES / page_of(place)).parent.mkdir(parents=True, exist_ok=True)
        (PAGES / page_of(place)).write_text(text, encoding="utf-8")
    home = linked((ROOT / "README.md").read_text(encoding="utf-8"), "", "")
    (PAGES / "index.md").write_text(home, encoding="utf-8")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        failed = [x for x in pool.map(live, models()) if x]
    for path in models():
        page = model_page(path)
        (PAGES / f"models/{path.stem}.md").write_text(page, encoding="utf-8")
    (PAGES / "models/index.md").write_text(gallery(), encoding="utf-8")
    settings = yaml.safe_load((HERE / "mkdocs.yml").read_text(encoding="utf-8"))
    settings |= {"nav": nav(), "docs_dir": "site-pages", "site_dir": "site"}
    (ROOT / "build/site.yml").write_text(yaml.safe_dump(settings, sort_keys=False))
    for words in failed:
        print(f"site: {words}", file=sys.stderr)
    return 1 if failed else 0


# -- links ----------------------------------------------------------------------------------------


def linked(text: str, folder: str, to: str) -> str:
    """Markdown of a folder of the repository for a page in the folder `to`, its links as there."""

    def moved(found: re.Match[str]) -> str:
        address, hash_, anchor = found[2].partition("#")
        if not address or re.match(r"[a-z]+:", address):
            return found[0]
        place = posixpath.normpath(posixpath.join(folder, address))
        target = posixpath.relpath(page_of(place), to or ".")
        return f"{found[1]}{target}{hash_}{anchor}{found[3]}"

    parts = re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(p if p.startswith("```") else LINK.sub(moved, p) for p in parts)


def page_of(place: str) -> str:
    """Where in the site a file of the repository is; one without a page gets one of its text."""
    path = Path(place)
    if place == "README.md":
        return "index.md"
    if path.parts[0] == "models" and path.suffix == ".lag":
        return f"models/{path.stem}.md"
    if place in ("models", "models/"):
        return "models/index.md"
    if path.parts[0] == "docs":
        inside = posixpath.relpath(place, "docs")
        if path.suffix == ".md" or inside.startswith("pictures/"):
            return inside
    if path.parts[0] == "addons" and len(path.parts) == 3 and path.suffix == ".md":
        return f"{path.parts[1]}.md" if path.name == "README.md" else path.name
    whole = ROOT / place
    if not whole.is_file():
        return "dev/architecture.md"  # a folder: the page about folders
    shown = PAGES / "files" / (place.replace("/", "_") + ".md")
    text = whole.read_text(encoding="utf-8")
    if path.suffix == ".md":
        text = LINK.sub(lambda found: found[0] if ":" in found[2] else f"`{found[2]}`", text)
    else:
        text = f"# {place}\n\n```{path.suffix.lstrip('.')}\n{text.rstrip()}\n```\n"
    shown.write_text(text, encoding="utf-8")
    return f"files/{shown.name}"


# -- models ---------------------------------------------------------------------------------------


def live(path: Path) -> str:
    """The live page of a model; what went wrong, if anything did."""
    if "\nsample " in path.read_text(encoding="utf-8"):  # which no live page runs
        return ""
    out = PAGES / f"live/{path.stem}.html"
    command = [sys.executable, "-m", "pkgen", "show", str(path), "-o", str(out), "--json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        return f"no live page of {path.stem}: {done.stderr.strip()}"
    made = json.loads(done.stdout)
    return "" if made["bytes"] <= 1_500_000 else f"{path.stem}: {made['bytes']:,} bytes"


def model_page(path: Path) -> str:
    source = read(str(path))
    compilation = compile_model(source, symmetric=True)
    place = path.relative_to(ROOT).as_posix()
    name, title = path.stem, path.stem.replace("_", " ")
    listed = [scene for scene in compilation.declared.scenes if scene.listed]
    scenes = [scene_shown(compilation, {}, scene) for scene in listed]
    shown = fragment(compilation, scenes, level=3)
    parts = [
        "---\nhide:\n  - toc\n---\n",
        f"# {title[0].upper()}{title[1:]}\n",
        f"{escape(compilation.model.description)}\n",
    ]
    if (PAGES / f"live/{name}.html").exists():
        parts += [
            f'<iframe class="live" src="../live/{name}.html" loading="lazy" '
            f'title="{escape(title)}, live"></iframe>\n',
            f'<a href="../live/{name}.html">In a window of its own</a>; from the command line '
            f"`pkgen show {place}`.\n",
        ]
    known = said_of(place)
    parts += ["## What is known of it\n", known] if known else []
    pictures = [
        (f"{kind}_{name}.svg", words)
        for kind, words in (("chart", "Accuracy against cost"), ("stability", "Where methods fail"))
        if (PAGES / f"pictures/{kind}_{name}.svg").exists()
    ]
    for file, words in pictures:
        parts += [f"## {words}\n", f"![{words}: {title}](../pictures/{file})\n"]
    parts += ["## The equations\n", shown, "## The model\n"]
    parts.append(f"`{place}`\n\n```lag\n{source.text.rstrip()}\n```\n")
    return "\n".join(parts)


def said_of(place: str) -> str:
    """The section of docs/dev/results/models.md that names the model in its heading."""
    text = (ROOT / "docs/dev/results/models.md").read_text(encoding="utf-8")
    heads = list(SECTION.finditer(text))
    ends = [head.start() for head in heads[1:]] + [len(text)]
    for head, end in zip(heads, ends, strict=True):
        named = [x if "/" in x else f"{folder_of(head[2])}{x}" for x in files_in(head[2])]
        if place.removeprefix("models/") in (*named, *files_in(head[2])):
            return linked(text[head.end() : end].strip() + "\n", "docs/dev/results", "models")
    return ""


def files_in(heading: str) -> list[str]:
    return re.findall(r"`([^`]*\.lag)`", heading)


def folder_of(heading: str) -> str:
    """Of the first file that a heading names: the others may be named without it."""
    first = files_in(heading)[:1]
    return first[0].rpartition("/")[0] + "/" if first and "/" in first[0] else ""


def gallery() -> str:
    parts = ["# Models\n", "Each is a file in `models/`; its page has the model itself, live.\n"]
    for folder, title in FOLDERS.items():
        cards = []
        for path in models():
            if path.parent == ROOT / "models" / folder:
                says = re.match(r"model \w+\s*#\s*(.*)", path.read_text(encoding="utf-8"))
                cards.append(
                    f'<li><a href="{path.stem}.html">{path.stem.replace("_", " ")}</a><br>'
                    f"{escape(says[1] if says else '')}</li>"
                )
        parts += [f"## {title}\n", f'<ul class="cards">{"".join(cards)}</ul>\n']
    return "\n".join(parts)


def nav() -> list[dict[str, object]]:
    names = [page_of(path.relative_to(ROOT).as_posix()) for path in texts()]
    pages = {Path(name).stem: name for name in names}
    found: list[dict[str, object]] = [{"Home": "index.md"}]
    used = {"models", *(name for names in SECTIONS.values() for name in names)}
    for title, names in SECTIONS.items():
        names = [n for n in names if n in pages] or sorted(pages.keys() - used)
        found.append({title: [pages[n] for n in names]})
    groups: list[object] = ["models/index.md", {"What each is known for": "dev/results/models.md"}]
    for folder, title in FOLDERS.items():
        inside = [p for p in models() if p.parent == ROOT / "models" / folder]
        # Counted, so that no part of a page has the same name as a part of the navigation.
        groups.append({f"{title}, {len(inside)}": [f"models/{p.stem}.md" for p in inside]})
    found.insert(2, {"Models": groups})
    return found


if __name__ == "__main__":
    sys.exit(main())
