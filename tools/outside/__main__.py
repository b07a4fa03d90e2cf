"""One side's pictures of one scene, in a process of its own: the renderers do not live well together."""
import importlib
import pathlib
import sys

import numpy as np

from .scenes import SCENES


def main(name, number, resolution, samples, seeds, folder, out, kinora):
    scene = SCENES[name]()
    side = scene.sides[int(number)]
    side.samples = max(1, round(side.samples * float(samples)))
    module = importlib.import_module(f".to_{side.renderer}", "outside")
    more = [kinora] if side.renderer == "kinora" else []
    pictures = [p for p in module.render(scene, side, int(resolution), range(1, int(seeds) + 1), pathlib.Path(folder), *more)]
    np.save(out, np.array(pictures))


main(*sys.argv[1:])
