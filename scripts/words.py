#!/usr/bin/env python3
"""Finds words that the project's glossary replaces, in code, tests, scripts, documentation and the page.

    scripts/lint words [FILES...]      all files of the project, or only some
    scripts/words.py --self-test       checks that each rule finds its example and nothing in plain sentences

One line for each word found: `FILE:LINE: "word": use ...`. Exit status 1 if there is any. scripts/words_allowed.txt lists the
exceptions, each with its reason; an exception that matches nothing is an error, so that the list stays short.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ALLOWED = ROOT / "scripts/words_allowed.txt"
CODE = {".cpp", ".h", ".hpp", ".c", ".ts", ".tsx", ".mjs", ".js"}
TEXT = {".md", ".py", ".css", ".cmake", ".sh", ".html", ".json", ".txt", ""}
SKIPPED = re.compile(r"^(LICENSE|web/package-lock\.json|scripts/words(_allowed)?\.(py|txt)|benchmarks/results/.*\.json|tests/fuzz/(seeds|dictionaries)/.*"
                     r"|tests/.*/versions/.*|\..*)$")

# (pattern, replacement, example). `prose` patterns are searched in comments, strings and documents, `name` patterns in identifiers
# (split at underscores and capitals: `greatest_speed` is "greatest speed").
PROSE = [
    (r"(?<!degree of )(?<!degrees of )\bfreedoms?\b", "degree(s) of freedom, DOF", "a joint with three freedoms"),
    (r"\bbrothers?\b", "sibling", "the next brother"),
    (r"\bgreatest\b", "maximum, largest", "the greatest speed"),
    (r"\b(told|tells?|telling)\b", "reported, prints, returns, specifies", "the user is told"),
    (r"\b(says?|saying)\b", "reports, states, specifies", "the file says so"),
    (r"\banew\b", "again: rebuilt, recomputed, retried", "it is built anew"),
    (r"\bonce more\b", "again", "the step is solved once more"),
    (r"\bmend(s|ed|ing)?\b", "fix, repair", "holes are mended"),
    (r"\bcoast(s|ed|ing)?\b", "integrate without contact forces, inertial substep", "the body coasts"),
    (r"\bcertain contacts?\b", "forced contacts", "certain contacts take part"),
    (r"\bstraight on\b", "name the action", "it goes straight on"),
    (r"\bbeyond measure\b", "name the bound", "it grew beyond measure"),
    (r"\btak(e|es|en|ing) apart\b", "split", "the step is taken apart"),
    (r"\btaken again\b", "solved again", "the step is taken again"),
    (r"\blet(s|ting)? go\b", "release, released", "it lets go of the bar"),
    (r"\bin (a )?circles?\b|\bcircles? of (parents|wires|lsis|links|includes)\b", "cycle, algebraic loop", "a circle of parents"),
    (r"\bnews\b", "update, message", "late news are dropped"),
    (r"\b(is|are) no more\b", "no longer exists, invalidated", "a page that is no more"),
    (r"\bfigures?\b(?! \d)", "character (a person or animal), value (a measured number)", "the figure walks"),
    (r"\bnearest pairs?\b", "closest pair, closest points", "the nearest pair of links"),
    (r"\bthings?\b", "the noun", "the thing that moves"),
    (r"\bparts of (a|the) step\b", "substeps", "the parts of a step"),
    (r"\bwith (its|their) place\b|\bplace and remedy\b", "location", "errors name place and remedy"),
    (r"\bwhat (moves|goes|stands|lies|comes|came)\b", "name the subject", "what moves is solved"),
    (r"\bthose with which\b", "name the noun", "those with which it began"),
    (r"\bof that[,.;:]", "name the noun", "maximum speed of that;"),
]
NAME = [
    (r"\bfreedoms?\b(?<!degree of freedom)(?<!degrees of freedom)", "dof", "freedom_scale"),
    (r"\bbrothers?\b", "sibling", "brother"),
    (r"\bgreatest\b", "max_", "greatest_speed"),
    (r"^(most|least)\b(?! squares)", "max_, min_", "most_rows"),
    (r"\b(told|tells?|says?|said)\b", "reported, notify, describe", "rate_told"),
    (r"\banew\b", "rebuilt, again", "distance_anew"),
    (r"\bmend(s|ed|ing)?\b", "repair", "mended_mesh"),
    (r"\bcoast(s|ed|ing)?\b", "inertial", "coasting_"),
    (r"^certain$", "forced", "certain"),
    (r"\blet go\b", "release, released", "let_go_time"),
    (r"\bnews\b", "update", "late_news"),
    (r"\bfigures?\b", "character", "figure_state"),
    (r"\bnearest pairs?\b", "closest_pair", "NearestPair"),
    (r"\bthings?\b", "the noun", "things_"),
]
PLAIN = """The degree of freedom of a hinge. Two degrees of freedom. A circle of radius r. At least two rows; at most ten. Figure 3 of the paper.
The nearest point. Something else, nothing, everything. The maximum of all rows. It is recommended. The news-free sentence."""
PLAIN_NAMES = ["degrees_of_freedom", "least_squares", "at_most", "sorted_at_least", "nearest_point", "anything", "essay", "recommended"]

PROSE_RULES = [(re.compile(p, re.I), use) for p, use, _ in PROSE]
NAME_RULES = [(re.compile(p), use) for p, use, _ in NAME]
TOKEN = re.compile(r'''(?P<comment>//[^\n]*(?:\n[ \t]*//[^\n]*)*|/\*.*?\*/)|(?P<raw>R"(?P<mark>[^(\s"]*)\(.*?\)(?P=mark)")|(?P<string>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')'''
                   r'''|(?P<template>`(?:\\.|[^`\\])*`)|(?P<name>[A-Za-z_$][\w$]*)''', re.S)


def words_of(name):
    """`greatest_speed`, `GreatestSpeed` -> "greatest speed"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).strip("_").replace("_", " ").lower()


def in_name(name):
    words = words_of(name)
    for rule, use in NAME_RULES:
        if found := rule.search(words):
            yield found.group().strip(), use


def in_prose(text):
    """(offset, word, replacement) in comments, strings and documents. A line break within a phrase counts as a blank."""
    flat, at, end = [], [], 0  # flat: the text with one blank for each line break and its indentation; at: offsets in `text`
    for gap in re.finditer(r"\s*\n[ \t]*(///?|\*|#)?[ \t]*", text):
        flat.append(text[end:gap.start()] + " ")
        at += range(end, gap.start() + 1)
        end = gap.end()
    flat = "".join(flat) + text[end:]
    at += range(end, len(text))
    for rule, use in PROSE_RULES:
        for found in rule.finditer(flat):
            yield at[found.start()], found.group(), use
    for name in re.finditer(r"\b[A-Za-z]\w*_\w+\b", text):
        for _, use in in_name(name.group()):
            yield name.start(), name.group(), use


def findings(path, text):
    """(line, word, replacement) in one file."""
    def line_at(offset):
        return text.count("\n", 0, offset) + 1

    if pathlib.Path(path).suffix not in CODE:
        for offset, word, use in in_prose(text):
            yield line_at(offset), word, use
        return
    for token in TOKEN.finditer(text):
        if token.lastgroup == "name":
            for _, use in in_name(token.group()):
                yield line_at(token.start()), token.group(), use
        else:
            for offset, word, use in in_prose(token.group()):
                yield line_at(token.start() + offset), word, use
    if path.endswith(".tsx"):  # text between tags
        for shown in re.finditer(r">([^<>{}=;()]*[A-Za-z][^<>{}=;()]*)<", text):
            for offset, word, use in in_prose(shown.group(1)):
                yield line_at(shown.start(1) + offset), word, use


def read_allowed():
    """[path pattern, line pattern, reason, number of uses]"""
    out = []
    for number, line in enumerate(ALLOWED.read_text().splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        fields = [field.strip() for field in line.split(" :: ")]
        if len(fields) != 3 or not fields[2]:
            sys.exit(f"{ALLOWED.name}:{number}: write PATH :: PATTERN :: REASON")
        out.append([re.compile(fields[0]), re.compile(fields[1]), f"{ALLOWED.name}:{number}", 0])
    return out


def self_test():
    wrong = [f'no rule finds "{example}"' for pattern, _, example in PROSE if not re.search(pattern, example, re.I)]
    wrong += [f'no rule finds the name "{example}"' for _, _, example in NAME if not list(in_name(example))]
    wrong += [f'"{word}" is found in a plain sentence' for _, word, _ in in_prose(PLAIN.replace("news-free", "plain"))]
    wrong += [f'"{name}" is found among plain names' for name in PLAIN_NAMES if list(in_name(name))]
    sample = 'int brother = 1;  // the greatest\nconst char* s = "told";\n/// a circle\n/// of parents\n'
    lines = sorted(line for line, _, _ in findings("a.cpp", sample))
    if lines != [1, 1, 2, 3]:
        wrong.append(f"findings of the sample are at lines {lines}")
    return wrong


def main():
    if sys.argv[1:] == ["--self-test"]:
        wrong = self_test()
        print("\n".join("not ok " + w for w in wrong) or "ok self-test of the word rules")
        return 1 if wrong else 0
    chosen = sys.argv[1:]
    files = chosen or subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    allowed = read_allowed()
    count = read = 0
    for name in files:
        path = pathlib.Path(name)
        if SKIPPED.match(name) or path.suffix not in CODE | TEXT or not (ROOT / path).is_file():
            continue
        try:
            text = (ROOT / path).read_text()
        except UnicodeDecodeError:
            continue
        if path.suffix == "" and not text.startswith("#!"):
            continue
        read += 1
        lines = text.split("\n")
        for line, word, use in sorted(set(findings(name, text))):
            excuse = next((a for a in allowed if a[0].search(name) and a[1].search(lines[line - 1])), None)
            if excuse:
                excuse[3] += 1
                continue
            count += 1
            print(f'not ok {name}:{line}: "{word}": use {use}')
    if not chosen:
        for _, _, where, uses in allowed:
            if uses == 0:
                count += 1
                print(f"not ok {where}: nothing matches this exception; remove it")
    if count == 0:
        print(f"ok no forbidden word in {read} files")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
