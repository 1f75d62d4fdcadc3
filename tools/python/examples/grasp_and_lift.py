"""Takes the liver with a grasper, lifts it 15 mm, and prints force and slip.

Usage: grasp_and_lift.py
"""

import numpy as np

import hpdm

PLACE = np.array([-0.03, -0.01, 0.05])  # m, near the surface

session = hpdm.Session(hpdm.scene_path("two_hands.toml"), command="tip")
hand = session.scene.instruments.index("grasper")
command = session.command["grasper"]    # x, y, z (m), roll (rad), jaw


def move(to, jaw, steps):
    """Moves the tip in a straight line."""
    way = np.linspace(command[:3], to, steps + 1)[1:]
    for place in way:
        command[:3] = place
        command[4] = jaw
        session.step()


down = PLACE - (session.tip[hand] - PLACE) / np.linalg.norm(session.tip[hand] - PLACE) * 0.003
move(down, 1.0, 30)                      # 3 mm into the tissue, jaws open
move(down, 0.0, 10)                      # close
assert session.contact_kind[hand] == 2, "the jaws hold nothing"
for lift in (5, 10, 15):
    move(down + [0, 0, lift / 1000], 0.0, 15)
    force = session.force[hand]
    print(f"lifted {lift:2d} mm: {np.linalg.norm(force):.3f} N on the hand, "
          f"slip {1000 * session.slip[hand]:.1f} mm, "
          f"the surface around moves up to {1000 * session.organs['liver'].displacements[:, 2].max():.1f} mm")
