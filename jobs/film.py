#!/usr/bin/python3
"""Makes an animation of the pictures that a script of the window filmed: frame_*.png.

usage: film.py FOLDER OUT.gif [--rate 10] [--width 640] [--colours 64]
"""
import argparse
import pathlib
import sys

from PIL import Image


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--rate", type=float, default=10, help="pictures a second")
    parser.add_argument("--width", type=int, default=640, help="pixels")
    parser.add_argument("--colours", type=int, default=64)
    asked = parser.parse_args()
    names = sorted(asked.folder.glob("frame_*.png"))
    if not names:
        sys.exit(f"film.py: {asked.folder}: no frame_*.png; a script with 'film RATE' makes them "
                 "(input/README.md, The window)")
    pictures = []
    for name in names:
        picture = Image.open(name).convert("RGB")
        height = round(picture.height * asked.width / picture.width)
        pictures.append(picture.resize((asked.width, height), Image.LANCZOS))
    # One palette for all, of the last picture, which has everything in it; by an octree, which keeps
    # the few pixels of a seed apart from the many of the tissue.
    palette = pictures[-1].quantize(asked.colours, method=Image.FASTOCTREE)
    pictures = [picture.quantize(palette=palette, dither=Image.NONE) for picture in pictures]
    pictures[0].save(asked.out, save_all=True, append_images=pictures[1:], loop=0,
                     duration=round(1000 / asked.rate), optimize=True)
    print(f"{asked.out}: {len(pictures)} pictures, {asked.out.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
