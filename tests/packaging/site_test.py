# SPDX-License-Identifier: MIT
"""The site builds without a warning; its links, and those to places within pages, lead somewhere; search finds."""
import json
import re
import shutil
import sys
import tempfile
from pathlib import Path
from urllib.parse import unquote, urldefrag

from ecosystem import SOURCE, command, skip

missing = [program for program in ("mkdocs", "doxygen") if shutil.which(program) is None]
if missing:
    skip("Packaging.Site", f"there is no {' and no '.join(missing)} (tools/install_packages site)")
with tempfile.TemporaryDirectory() as name:
    site = Path(name) / "site"
    command(SOURCE, sys.executable, str(SOURCE / "tools/site"), str(site))
    anchors = {}
    for page in [*site.glob("*.html"), *site.glob("experiments/*.html")]:
        anchors[page] = set(re.findall(r'\bid="([^"]+)"', page.read_text(encoding="utf-8")))
    count = 0
    for page in anchors:
        text = page.read_text(encoding="utf-8")
        for link in re.findall(r'(?:href|src)="([^"]+)"', text):
            if re.match(r"[a-z]+:|//|/", link) or page.name in ("404.html", "search.html"):
                continue
            target, anchor = urldefrag(unquote(link))
            path = (page.parent / target).resolve() if target else page
            assert path.exists(), f"{page.name}: {link}"
            assert not anchor or path not in anchors or anchor in anchors[path] | {""}, f"{page.name}: {link}"
            count += 1
    index = json.loads((site / "search/search_index.json").read_text(encoding="utf-8"))["docs"]
    for words, place in (("Decode here", "blender.html"), ("--landmarks marks.csv", "tutorial.html"),
                         ("plain square", "experiments/embedding.html")):
        assert any(words in entry["text"] and entry["location"].startswith(place) for entry in index), words
    reference = (site / "reference/classshape_1_1_embedder.html")
    assert reference.exists() or any((site / "reference").glob("classshape_1_1*mbedder.html"))
    assert (site / "reference/search").is_dir()
    print(f"{len(anchors)} pages, {count} links, {len(index)} places that search knows")
