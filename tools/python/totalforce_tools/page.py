# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""A self-contained HTML page: pictures as SVG whose marks have titles, tables, text. No script, and
nothing that is loaded from elsewhere."""
import html
import re

from totalforce_tools import style

TEMPLATE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ margin: 1.5em auto; max-width: 70em; padding: 0 1em; font: 15px/1.45 sans-serif; }}
h1 {{ font-size: 1.45em; margin-bottom: 0.2em; }}
h2 {{ font-size: 1.15em; margin: 1.6em 0 0.3em; }}
.origin {{ color: #555; font-size: 0.87em; overflow-wrap: anywhere; }}
figure {{ margin: 1em 0; overflow-x: auto; }}
svg {{ max-width: 100%; height: auto; }}
svg g:has(> title):hover {{ opacity: 0.5; }}
table {{ display: block; overflow-x: auto; border-collapse: collapse;
  font-size: 0.87em; font-variant-numeric: tabular-nums; }}
th, td {{ padding: 0.15em 0.7em; text-align: right; border-bottom: 1px solid #ddd; }}
th:first-child, td:first-child {{ text-align: left; }}
thead th {{ position: sticky; top: 0; background: #fff; }}
details {{ margin: 1em 0; overflow-x: auto; }}
summary {{ cursor: pointer; }}
</style>
</head>
<body>
<h1>{title}</h1>
<p class="origin">{origin}</p>
{body}
</body>
</html>
"""


def text(words):
    """A paragraph"""
    return f"<p>{html.escape(words)}</p>"


def heading(words):
    return f"<h2>{html.escape(words)}</h2>"


def figure(drawn, titles=None, about=""):
    """A picture; `titles` has the text that a mark shows under the pointer, by the gid of its
    artist. `about` is the picture in words, for those who do not see it."""
    svg = style.svg(drawn)
    for gid, words in (titles or {}).items():
        group = f'<g id="{gid}">'
        svg = svg.replace(group, f"{group}<title>{html.escape(words)}</title>", 1)
    # ids are unique in a page
    figure.count += 1
    mine = f"f{figure.count}-"
    svg = re.sub(r'\bid="', f'id="{mine}', svg)
    svg = re.sub(r'(href="|url\()#', rf"\1#{mine}", svg)
    label = f' role="img" aria-label="{html.escape(about)}"' if about else ""
    return f"<figure>{svg.replace('<svg', f'<svg{label}', 1)}</figure>"


figure.count = 0


def table(head, rows):
    """Cells are text, or numbers that are shown with four digits."""
    def cells(kind, row):
        return "".join(f"<{kind}>{html.escape(cell_text(cell))}</{kind}>" for cell in row)

    body = "\n".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return f"<table><thead><tr>{cells('th', head)}</tr></thead>\n<tbody>\n{body}\n</tbody></table>"


def cell_text(cell):
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)


def folded(summary, content):
    """Content that is shown on demand"""
    return f"<details><summary>{html.escape(summary)}</summary>\n{content}\n</details>"


def write(out, title, machine, date, command, parts):
    """The page: a title that states the conclusion, where it comes from, and its parts."""
    origin = html.escape(f"{machine}, {date}: {command}")
    out.write(TEMPLATE.format(title=html.escape(title), origin=origin, body="\n".join(parts)))
