"""XDMF: a page of XML by which ParaView and VisIt open the checkpoints of a run as one series in time.

It describes the meshes and fields in the HDF5 files, and holds no numbers but the times. Cells are rectilinear and
fields are cell averages. XDMF lists dimensions from the slowest to the fastest, which in a checkpoint is x.
See https://www.xdmf.org/index.php/XDMF_Model_and_Format.
"""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import escape

from hydro.mesh import Mesh
from hydro.output.checkpoint import FIELDS, checkpoint_times
from hydro.output.files import write_text

SERIES = """\
<?xml version="1.0"?>
<Xdmf Version="2.0">
<Domain>
<Grid Name="run" GridType="Collection" CollectionType="Temporal">
{moments}
</Grid>
</Domain>
</Xdmf>
"""
MOMENT = """\
<Grid Name="{name}" GridType="Uniform">
<Time Value="{time!r}"/>
<Topology TopologyType="2DRectMesh" Dimensions="{y_faces} {x_faces}"/>
<Geometry GeometryType="VXVY">
{geometry}
</Geometry>
{attributes}
</Grid>"""
ATTRIBUTE = """\
<Attribute Name="{name}" AttributeType="Scalar" Center="Cell">
{item}
</Attribute>"""
ITEM = '<DataItem Dimensions="{shape}" NumberType="Float" Precision="8" Format="HDF">{file}:/{name}</DataItem>'


class Series:
    """The page of the checkpoints in a folder, to be updated when one is written or removed.

    It remembers the times of those it has seen, so that an update does not open them all.
    """

    def __init__(self, page: Path, folder: Path, mesh: Mesh):
        self.page, self.folder, self.mesh = page, folder, mesh
        self._times: dict[Path, float] = {}

    def update(self) -> None:
        """Write the page anew, of the checkpoints that are there and can be read."""
        self._times, _ = checkpoint_times(self.folder, self._times)
        moments = "\n".join(self._moment(path, time) for path, time in self._times.items())
        write_text(self.page, SERIES.format(moments=moments))

    def _moment(self, path: Path, time: float) -> str:
        nx, ny = self.mesh.cells
        file = escape(path.relative_to(self.page.parent).as_posix())
        faces = [(f"{nx + 1}", "x_faces"), (f"{ny + 1}", "y_faces")]
        return MOMENT.format(
            name=escape(path.stem),
            time=time,
            x_faces=nx + 1,
            y_faces=ny + 1,
            geometry="\n".join(ITEM.format(shape=shape, file=file, name=name) for shape, name in faces),
            attributes="\n".join(
                ATTRIBUTE.format(name=name, item=ITEM.format(shape=f"{ny} {nx}", file=file, name=name))
                for name, _, _ in FIELDS
            ),
        )
