"""What the scripts that make meshes share: a Gmsh file that is there whole or not at all."""

import os

from own_files import BadInput


def refuse_existing(path, force):
    if os.path.exists(path) and not force:
        raise BadInput(f"{path}: exists; give --force to overwrite it")
    if not os.path.isdir(os.path.dirname(path) or "."):
        raise OSError(f"{path}: cannot be written: there is no such folder")


def write(gmsh, path):
    """The model as ASCII of format 4.1, beside the target and then renamed. Raises OSError."""
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 0)
    part = f"{path}.{os.getpid()}.part.msh"
    try:
        gmsh.write(part)
        os.replace(part, path)
    except Exception as error:
        if os.path.exists(part):
            os.remove(part)
        raise OSError(f"{path}: cannot be written: {error}") from None
