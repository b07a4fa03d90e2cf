"""The page that render_all --sheet writes: every picture beside its author's, with what the program said and an eye's verdict.

Verdicts are one JSON object, {"file": {"verdict": "yes|partly|no|waits|empty", "why": "cause: ..."}}; the page changes them and
gives the object back, to be saved and given to --verdicts the next time. `waits` is for what needs a part of Kinora that is not
there yet, `empty` for what shows nothing in any renderer: passes that make maps, pieces of other scenes, tests of broken files.
A reason begins with its cause in a word or two and a colon, by which the page counts.
"""
import html
import json
import re
import shutil
import subprocess

VERDICTS = {"yes": "recognisable", "partly": "partly", "no": "no", "waits": "waits", "empty": "nothing to show"}
PICTURES = (".png", ".jpg", ".jpeg", ".gif", ".tif", ".tiff", ".bmp")
SHOWN_BY_BROWSERS = (".png", ".jpg", ".jpeg", ".gif", ".bmp")
TEXTURE_FOLDER = re.compile(r"tex|map|ptc|hdr", re.I)
MOST_PICTURES = 3


def words_of(name):
    return {w for w in re.split(r"[^a-z]+", name.lower()) if len(w) > 2}


def authors_pictures(root, rib):
    """Pictures that may show what `rib` means, likeliest first: same name, same folder, nearby names."""
    found = []
    stem = rib.name.split(".rib")[0].lower()
    words = words_of(stem)
    for path in root.rglob("*"):
        if path.suffix.lower() not in PICTURES or not path.is_file():
            continue
        inside = path.relative_to(root)
        if any(TEXTURE_FOLDER.search(part) for part in inside.parts[:-1]):
            continue
        same_folder = path.parent == rib.parent
        below = rib.parent in path.parents
        name = path.stem.lower()
        score = 8 * (name == stem) + 4 * (stem in name or name in stem) + 3 * same_folder + 1 * below
        score += 2 * len(words & words_of(name)) - 0.1 * abs(len(inside.parts) - len(rib.relative_to(root).parts))
        if score >= 3:
            found.append((-score, str(path), path))
    # the same picture in two formats once, the one that browsers show
    found.sort()
    best = {}
    for _, _, path in found:
        other = best.get(path.with_suffix(""))
        if other is None or (other.suffix.lower() not in SHOWN_BY_BROWSERS and path.suffix.lower() in SHOWN_BY_BROWSERS):
            best[path.with_suffix("")] = path
    return list(best.values())[:MOST_PICTURES]


def shown(path, out):
    """A file that a browser shows: the picture itself or a copy as PNG; None where no converter is installed."""
    if path.suffix.lower() in SHOWN_BY_BROWSERS:
        return path
    copy = out / "authors" / (re.sub(r"[^A-Za-z0-9_.-]", "_", str(path).lstrip("/")) + ".png")
    if copy.exists():
        return copy
    copy.parent.mkdir(exist_ok=True)
    for converter in (["oiiotool", path, "-o", copy], ["convert", f"{path}[0]", "-alpha", "off", copy]):
        if shutil.which(converter[0]):
            subprocess.run([str(c) for c in converter], capture_output=True, check=False)
            if copy.exists():
                return copy
    return None


def some_of(pictures):
    """The first, one in the middle, the last: passes that make maps come first, and frames move."""
    if len(pictures) <= MOST_PICTURES:
        return pictures
    return [pictures[0], pictures[len(pictures) // 2], pictures[-1]]


def counts_of(rows, verdicts):
    counts = dict.fromkeys([*VERDICTS, "none"], 0)
    for row in rows:
        if row["result"] != "no world":
            counts[verdicts.get(row["file"], {}).get("verdict", "none")] += 1
    return counts


def summary_of(counts):
    judged = counts["yes"] + counts["partly"] + counts["no"]
    share = f", {100 * counts['yes'] / judged:.0f} % of those that wait for nothing are recognisable" if judged else ""
    return (f"{counts['yes']} recognisable, {counts['partly']} partly, {counts['no']} not, {counts['waits']} wait, {counts['empty']} have nothing to show, "
            f"{counts['none']} without a verdict{share}")


def causes_of(rows, verdicts):
    """What the reasons of a verdict begin with, by verdict: how often."""
    causes = {}
    for row in rows:
        v = verdicts.get(row["file"], {})
        if row["result"] != "no world" and ":" in v.get("why", ""):
            key = (v["verdict"], v["why"].split(":")[0].strip())
            causes[key] = causes.get(key, 0) + 1
    return ", ".join(f"{VERDICTS[v]} for {cause} {n}" for (v, cause), n in sorted(causes.items(), key=lambda x: (x[0][0], -x[1])))


STYLE = """body{font:14px sans-serif;background:#333;color:#ddd;margin:1em}
.scene{border-top:1px solid #666;padding:.6em 0;display:flex;gap:1em;flex-wrap:wrap}
.scene img{max-height:240px;max-width:360px;background:#555}
.text{width:26em}.fault{color:#f66}pre{white-space:pre-wrap;font-size:11px;max-height:9em;overflow:auto}
figure{margin:0}figcaption{font-size:11px;color:#aaa}textarea{width:95%}"""

SCRIPT = """function save(){const all={};for(const s of document.querySelectorAll('.scene')){
const v=s.querySelector('input:checked');if(v)all[s.dataset.file]={verdict:v.value,why:s.querySelector('textarea').value};}
const a=document.createElement('a');a.href=URL.createObjectURL(new Blob([JSON.stringify(all,null,1)]));
a.download='verdicts.json';a.click();}"""


def scene(folder, out, row, verdict):
    q = html.escape
    rib = folder / row["file"]
    root = folder / row["file"].split("/")[0]
    figures = []
    for name in some_of(row["pictures"]):
        figures.append(f'<figure><img loading="lazy" src="{q(name)}"><figcaption>Kinora: {q(name)}</figcaption></figure>')
    for path in authors_pictures(root if root.is_dir() else folder, rib):
        see = shown(path, out)
        picture = f'<img loading="lazy" src="{q(see.as_uri() if see.is_absolute() else str(see))}">' if see else "(no converter)"
        figures.append(f"<figure>{picture}<figcaption>author: {q(str(path.relative_to(folder)))}</figcaption></figure>")
    boxes = " ".join(
        f'<label><input type="radio" name="{q(row["file"])}" value="{v}"{" checked" if verdict.get("verdict") == v else ""}>'
        f"{text}</label>" for v, text in VERDICTS.items())
    fault = ' class="fault"' if row["result"] != "picture" else ""
    return (f'<div class="scene" data-file="{q(row["file"])}"><div class="text"><b>{q(row["file"])}</b><br>'
            f'<span{fault}>{row["result"]}</span>, {row["frames"]} pictures, {row["seconds"]:.1f} s, code {row["code"]}<br>{boxes}'
            f'<textarea rows="2">{q(verdict.get("why", ""))}</textarea><pre>{q(row["text"])}</pre></div>{"".join(figures)}</div>')


def write(sheet, folder, out, rows, verdicts):
    """`sheet`: the page; pictures are those in `out`. Files that are no scenes are left out. Returns the line that sums up."""
    line = summary_of(counts_of(rows, verdicts))
    if causes := causes_of(rows, verdicts):
        line += "; " + causes
    parts = [f"<!doctype html><meta charset=utf-8><title>Contact sheet</title><style>{STYLE}</style><script>{SCRIPT}</script>",
             f"<h1>{html.escape(str(folder))}</h1><p>{html.escape(line)} <button onclick=save()>save verdicts</button></p>"]
    parts += [scene(folder, out, row, verdicts.get(row["file"], {})) for row in rows if row["result"] != "no world"]
    sheet.write_text("\n".join(parts), encoding="utf-8")
    return line


def read_verdicts(path):
    if path is None or not path.exists():
        return {}
    verdicts = json.loads(path.read_text(encoding="utf-8"))
    wrong = [f for f, v in verdicts.items() if v.get("verdict") not in VERDICTS]
    if wrong:
        raise SystemExit(f"render_all: {path}: no verdict of {', '.join(VERDICTS)} for {wrong[0]}")
    return verdicts
