"""Renders the cases of cases.json with Jinja. The results are the table oracle.json, with which the C++ test compares.

  python3 oracle.py check    exit 0 if Jinja still agrees with the table, 77 if no Jinja from 3.1.5 on is installed
  python3 oracle.py write    writes the table again (needs the package jinja2)

A case is a list of lines (the template `main`), or an object of templates of which `main` is rendered. An error of Jinja
stands in the table as null.
"""

import json
import pathlib
import sys

HERE = pathlib.Path(__file__).parent


def rendered(templates):
    import jinja2
    environment = jinja2.Environment(loader=jinja2.DictLoader(templates), extensions=["jinja2.ext.do"])
    try:
        return environment.get_template("main").render()
    except Exception:  # of any kind: Python's own for operands, Jinja's for syntax and names
        return None


def table():
    out = []
    for case in json.loads((HERE / "cases.json").read_text()):
        templates = {"main": case} if isinstance(case, (str, list)) else case
        templates = {name: text if isinstance(text, str) else "\n".join(text) for name, text in templates.items()}
        out.append({"templates": templates, "output": rendered(templates)})
    return out


def main():
    try:
        import jinja2
    except ImportError:
        print("Jinja is not installed")
        return 77
    if tuple(map(int, jinja2.__version__.split(".")[:3])) < (3, 1, 5):
        print(f"Jinja {jinja2.__version__} makes no number of inf; expected 3.1.5 or later")
        return 77
    fresh = table()
    if sys.argv[1:] == ["write"]:
        (HERE / "oracle.json").write_text(json.dumps(fresh, indent=1) + "\n")
        return 0
    known = json.loads((HERE / "oracle.json").read_text())
    for was, now in zip(known, fresh):
        if was != now:
            print(f"the table says {was['output']!r}, Jinja says {now['output']!r} for {now['templates']}")
            return 1
    return 0 if len(known) == len(fresh) else 1


if __name__ == "__main__":
    sys.exit(main())
