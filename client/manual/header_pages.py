"""header_pages: manual pages of section 3 from the comments of a public header, collided.h or collided_load.h: an
overview, and a page for each function.

Run by the build: header_pages.py HEADER PACKAGE FOLDER RELEASE; PACKAGE is pkg-config's name of it. A function, structure or enumeration without a comment of its
own ends the build: the comment stands before it, behind it on its line, or behind a structure's first brace.
"""

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

HEADER = Path(sys.argv[1] if len(sys.argv) > 1 else "collided.h").name
BRIEF_MOST = 100
COMMENT = re.compile(r"/\*(.*?)\*/", re.S)
# A comment before, the declaration up to the ';' outside of braces, and a comment behind it on the same line.
DECLARATION = re.compile(
    r"(?P<before>/\*(?:(?!\*/).)*\*/\n)?"
    r"(?P<code>(?:typedef |enum |const |int |int64_t |size_t |void |collided)(?:[^;{}]|\{[^{}]*\})*;)"
    r"(?P<after>[ \t]*/\*(?:(?!\*/).)*\*/)?", re.S)
PARTS = re.compile(r"^/\* ---- (?P<title>.*?) ---- \*/$", re.M)


@dataclass
class Declaration:
    name: str
    code: str
    source: str  # with the comments before and behind it
    comment: str
    is_function: bool
    group: str = ""  # a comment that stands above several makers


@dataclass
class Section:
    title: str
    declarations: list = field(default_factory=list)


def comment_text(raw):
    """The text of one comment, without its stars."""
    if not raw:
        return ""
    lines = COMMENT.search(raw).group(1).strip().splitlines()
    return "\n".join(re.sub(r"^\s*\* ?", "", line).rstrip() for line in lines)


def name_of(code):
    bare = COMMENT.sub("", code).strip()
    if bare.startswith("typedef void"):
        return re.match(r"typedef void (\w+)\(", bare).group(1), False
    if bare.startswith("typedef"):
        return re.search(r"(\w+);$", bare).group(1), False
    if bare.startswith("enum"):
        return re.search(r"\{\s*(\w+)", bare).group(1), False
    return re.search(r"(\w+)\(", bare).group(1), True


def parse_section(title, text):
    section = Section(title)
    group, end = "", 0
    for match in DECLARATION.finditer(text):
        if "\n\n" in text[end:match.start()] or match.start() == 0:
            group = ""
        end = match.end()
        before, after = comment_text(match["before"]), comment_text(match["after"])
        opening = re.match(r"typedef (?:struct|enum) \w+ \{ (/\*.*?\*/)", match["code"], re.S)
        inner = comment_text(opening.group(1)) if opening else ""
        name, is_function = name_of(match["code"])
        if is_function and before and after:  # the first one of a group
            group, before = before, ""
        comment = "\n\n".join(part for part in (before, inner, after) if part)
        if not comment:
            sys.exit(f"{HEADER}: {name} has no comment")
        section.declarations.append(
            Declaration(name, match["code"], match[0].strip(), comment, is_function, group if is_function else ""))
    return section


def parse(text):
    overview, rest = re.match(r"(/\*.*?\*/)\n(.*)", text, re.S).groups()
    body = rest[rest.index('extern "C" {\n#endif\n') + len('extern "C" {\n#endif\n'):rest.rindex("#ifdef __cplusplus")]
    pieces = PARTS.split(body)
    titles = ["types and statuses"] + pieces[1::2]
    sections = [parse_section(t, p.strip("\n")) for t, p in zip(titles, pieces[0::2])]
    found = {d.name for s in sections for d in s.declarations}
    declared = set(re.findall(r"\b(collided_\w+)\(", COMMENT.sub("", body))) | set(
        re.findall(r"\btypedef (?:struct|enum) (\w+)", COMMENT.sub("", body)))
    if declared - found:
        sys.exit(f"{HEADER}: not understood: {', '.join(sorted(declared - found))}")
    return comment_text(overview), sections


# ---- roff ----


def escape(text):
    for plain, escaped in (("\\", "\\(rs"), ("'", "\\(aq"), ('"', "\\(dq"), ("`", "\\(ga"), ("^", "\\(ha"), ("~", "\\(ti")):
        text = text.replace(plain, escaped)
    text = re.sub(r"(?<![A-Za-z])-|-(?![A-Za-z])", r"\\-", text)
    return re.sub(r"^\.", r"\\&.", text, flags=re.M)


def prose(text):
    """Comment text as paragraphs; lines with four spaces before them are code."""
    out = []
    for block in re.split(r"\n\s*\n", text):
        code = block.startswith("    ")
        if out:
            out.append(".PP")
        out.append(f".EX\n{escape(block)}\n.EE" if code else escape(block))
    return "\n".join(out)


def code(text):
    return f".EX\n{escape(text)}\n.EE"


def sentence(text):
    text = " ".join(text.split())
    return (text[0].upper() + text[1:]).rstrip(".") + "."


def brief(declaration):
    """What stands in the line NAME: the comment up to its first '.', ':' or ';' outside of parentheses, whole."""
    text = " ".join(declaration.comment.split())
    first = re.match(r"(?:\([^)]*\)|[^.:;(]|[.:;](?!\s|$))*", text)[0]
    if not first or len(first) > BRIEF_MOST:
        sys.exit(f"{HEADER}: {declaration.name}: its comment must begin with a sentence of at most {BRIEF_MOST} letters")
    return first if first[1:2].isupper() else first[0].lower() + first[1:]


def heading(title, release):
    return f'.TH {escape(title)} 3 2026-11-21 "collided {release}" "Library functions"'


def types_of(function, types):
    """The types that a function's text names, without the plain handles."""
    words = re.findall(r"\w+", COMMENT.sub("", function.code))
    return [types[w] for w in dict.fromkeys(words) if w in types and w not in ("collided", "collided_status")]


def function_page(function, types, others, release):
    texts = [sentence(function.comment) if function.group else function.comment, function.group]
    lines = [heading(function.name.upper(), release), ".SH NAME", f"{function.name} \\- {escape(brief(function))}",
             ".SH SYNOPSIS", ".nf", f".B #include <{HEADER}>", ".PP", code(function.code), ".fi",
             ".SH DESCRIPTION", prose("\n\n".join(t for t in texts if t)),
             ".PP", "Units, frames, threads, ownership and errors are those of all functions:", "see",
             f".BR {HEADER} (3)."]
    named = types_of(function, types)
    if named:
        lines.append(".SH TYPES")
        for one in named:
            lines += [".PP", code(one.source)]
    lines.append(".SH SEE ALSO")
    near = [o.name for o in others if o.name != function.name][:8]
    lines += [f".BR {n} (3)," for n in near] + [f".BR {HEADER} (3),", ".BR collided (8)"]
    return "\n".join(lines) + "\n"


def overview_page(text, sections, package, release):
    title, _, rest = text.partition("\n\n")
    lines = [heading(HEADER.upper(), release), ".SH NAME",
             f"{HEADER} \\- {escape(title.partition(': ')[2].replace(' collided(8)', '').rstrip('.'))}",
             ".SH SYNOPSIS", ".nf", f".B #include <{HEADER}>", ".PP",
             f"cc client.c $(pkg\\-config \\-\\-cflags \\-\\-libs {escape(package)})", ".fi",
             ".SH DESCRIPTION", prose(rest)]
    for section in sections:
        lines.append(f".SH {escape(section.title.upper())}")
        for one in section.declarations:
            if one.is_function:
                lines += [".TP", f".BR {one.name} (3)", escape(sentence(brief(one)))]
            else:
                lines += [".PP", code(one.source)]
    lines += [".SH SEE ALSO", ".BR collided (8),", ".BR collidectl (1)"]
    return "\n".join(lines) + "\n"


def main(header, package, folder, release):
    overview, sections = parse(Path(header).read_text(encoding="utf-8"))
    types = {d.name: d for s in sections for d in s.declarations if not d.is_function}
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.3"):  # of functions that are gone
        old.unlink()
    (folder / f"{HEADER}.3").write_text(overview_page(overview, sections, package, release), encoding="utf-8")
    for section in sections:
        functions = [d for d in section.declarations if d.is_function]
        for one in functions:
            page = function_page(one, types, functions, release)
            (folder / f"{one.name}.3").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit("usage: header_pages.py HEADER PACKAGE FOLDER RELEASE")
    main(*sys.argv[1:])
