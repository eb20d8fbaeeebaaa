"""Self-tests of the physics against closed forms: ``grasp-bench doctor --physics``.

Every check runs in a trial's own scene (:mod:`grasp_bench.scene.builder`): the same arm, gripper,
pads, contacts and solver settings; only the objects are simpler.
"""
