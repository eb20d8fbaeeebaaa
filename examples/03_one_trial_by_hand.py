"""One trial by hand: the scene, the picture, the grasp, the motion, the verdict.

Run it with:  python examples/03_one_trial_by_hand.py
It lifts 1 of 1.
"""

import grasp_bench as gb


def main() -> gb.Trial:
    cell = gb.Workcell(gb.load_scenario("table4"))
    mug = gb.load_object("coffee_mug")
    trial = gb.run_trial(cell, mug, gb.load_predictor("antipodal"), seed=3)

    image, record, plan = trial.image, trial.record, trial.plan
    print(f"{mug.name}: {1000 * mug.mass:.0f} g, friction {mug.friction:g}, {len(mug.hulls)} convex pieces")
    if image is not None:
        print(
            f"image {image.rgb.shape}, its middle {image.depth[240, 320]:.3f} m away, "
            f"focal length {image.intrinsics.fx:.0f} px"
        )
    if plan is not None:
        print(f"{len(trial.grasps)} grasps proposed, number {record.rank} carried out: {record.grasp}")
        print(
            f"TCP at {plan.pose.position.round(3)} m, jaws {1000 * plan.pose.opening:.0f} mm apart, "
            f"{len(plan.approach.positions)} commands on the way down"
        )
    print(
        f"{record.outcome}: lifted {1000 * record.lift_height:.0f} mm, held with "
        f"{record.contact_force:.0f} N {record.detail}"
    )
    return trial


if __name__ == "__main__":
    main()
