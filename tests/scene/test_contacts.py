"""Which contacts the judge and the floating gripper see."""

from __future__ import annotations

import mujoco
import numpy as np

from grasp_bench.scene.contacts import touching

BALLS = """<mujoco>
  <worldbody>
    <geom name="ground" type="plane" size="1 1 1"/>
    <body pos="0 0 0.0999"><freejoint/><geom name="low" size="0.1"/></body>
    <body pos="0 0 0.2998"><freejoint/><geom name="high" size="0.1"/></body>
    <body pos="0.5 0 0.5"><freejoint/><geom name="far" size="0.1"/></body>
  </worldbody>
</mujoco>"""


def test_contacts_are_found_from_either_side() -> None:
    model = mujoco.MjModel.from_xml_string(BALLS)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ground, low, high, far = (np.arange(4) == model.geom(n).id for n in ("ground", "low", "high", "far"))
    pairs = [{model.geom(int(g)).name for g in pair} for pair in data.contact.geom]
    assert sorted(map(sorted, pairs)) == [["ground", "low"], ["high", "low"]]
    assert [pairs[i] for i in touching(data, low, ground)] == [{"ground", "low"}]
    assert [pairs[i] for i in touching(data, ground, low)] == [{"ground", "low"}]
    assert len(touching(data, low)) == 2
    assert len(touching(data, ground, high)) == len(touching(data, far)) == 0


def test_nothing_touches_where_there_are_no_contacts() -> None:
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    assert len(touching(mujoco.MjData(model), np.ones(1, bool))) == 0
