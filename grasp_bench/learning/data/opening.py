"""Opens copies of Cornell and Jacquard, which differ in their files."""

from __future__ import annotations

from pathlib import Path

from grasp_bench.errors import AssetError
from grasp_bench.learning.data.cornell import Cornell
from grasp_bench.learning.data.jacquard import Jacquard
from grasp_bench.learning.data.rectangles import Collection
from grasp_bench.learning.data.scenes import INDEX, is_generated
from grasp_bench.runs.evaluation import DatasetName


def open_collection(
    root: Path, name: DatasetName | None = None, depth: str = "perfect", *, generated: bool = False
) -> Collection:
    """Find the Cornell or Jacquard copy in ``root``; its files tell which of them unless it is named.

    Args:
        root: folder of a full copy or a part; images may be in folders below.
        name: data set that must be there.
        depth: which of Jacquard's is read: 'perfect' (rendered) or 'stereo' (with a simulated sensor's
            errors).
        generated: whether generated scenes would have done as well: an error says so.

    Raises:
        AssetError: when there is no complete sample with a usable label.
    """
    root = Path(root)
    if not root.is_dir():
        what = "generated scenes or the root" if generated else "the root"
        raise AssetError(f"{root} is not a folder; give {what} of a Cornell or Jacquard copy.")
    makers = {"cornell": lambda: Cornell.open(root), "jacquard": lambda: Jacquard.open(root, depth)}
    for key in (name,) if name else makers:
        found: Collection = makers[key]()
        if found.entries:
            return found
        if found.notes:
            raise AssetError(f"No sample in {root} can be used. {' '.join(found.notes)}")
        if found.missing:
            raise AssetError(
                f"No sample in {root} is complete: {', '.join(found.missing[:5])} "
                f"{'is' if len(found.missing) == 1 else 'are'} missing."
            )
    wanted = {"cornell": "Cornell (pcdNNNNcpos.txt)", "jacquard": "Jacquard (…_grasps.txt)"}
    none = f"no {wanted[name] if name else ' and no '.join(wanted.values())} files"
    if generated:
        raise AssetError(
            f"{root} holds no generated scenes ({INDEX}), {none}; make scenes with `grasp-bench data synth`, "
            "or give the root of a copy in its original layout."
        )
    instead = " but generated scenes" if is_generated(root) else ""
    raise AssetError(f"{root} holds {none}{instead}; give the root of a copy in its original layout.")
