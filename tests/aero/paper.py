"""The paper's model typed from its text, filament by filament: slow, plain, and no code of the package in it.

Names are the paper's.  Positions are absolute, as there; the leader is at (x_L, y_L, z_L).
"""

import math

import numpy as np


def velocity_of_filament(r_0, r_1, r_2, circulation, r_c):
    """Return the velocity at a point, outside the core (v_ind) or inside it."""
    a, b, c = r_2 - r_1, r_0 - r_1, r_0 - r_2
    b_cross_c = np.cross(b, c)
    r = np.linalg.norm(b_cross_c) / np.linalg.norm(a)
    cosines = b / np.linalg.norm(b) - c / np.linalg.norm(c)
    if r > r_c:
        return circulation / (4 * math.pi) * b_cross_c / (b_cross_c @ b_cross_c) * (a @ cosines)
    return circulation / (4 * math.pi) * b_cross_c / r_c**2 * (a / (a @ a) @ cosines)


def filaments(state, x_l, y_l, z_l, h_l, r_l, b, wavelength):
    """Return the eight filaments of the leader's wake: start, end and sign of circulation of each.

    Right-hand tips and starting vortices are positive, left-hand tips and stopping vortices negative.
    """
    shift = {"up": 0.0, "down": wavelength / 2}[state]
    # (first x, last x, first z, last z, half the width) of the upstroke's and of the downstroke's rectangle
    upstroke = (
        x_l + shift,
        x_l + shift + wavelength / 2,
        z_l + h_l / 2,
        z_l - h_l / 2,
        math.pi * b * r_l / 4,
    )
    downstroke = (
        x_l + wavelength / 2 - shift,
        x_l + wavelength - shift,
        z_l - h_l / 2,
        z_l + h_l / 2,
        math.pi * b / 4,
    )
    found = []
    for first_x, last_x, first_z, last_z, half in (upstroke, downstroke):
        right, left = y_l + half, y_l - half
        found += [
            ((first_x, right, first_z), (last_x, right, last_z), +1),  # right tip
            ((first_x, left, first_z), (last_x, left, last_z), -1),  # left tip
            ((first_x, left, first_z), (first_x, right, first_z), +1),  # starting vortex
            ((last_x, left, last_z), (last_x, right, last_z), -1),  # stopping vortex
        ]
    return [(np.array(start), np.array(end), sign) for start, end, sign in found]


def velocity(r_0, wake, circulation, r_c):
    """Return the velocity that a wake's filaments induce at a point."""
    return sum(velocity_of_filament(r_0, start, end, sign * circulation, r_c) for start, end, sign in wake)


def wingtips(state, x_f, y_f, z_f, h_f, r_f, b):
    """Return the follower's right and left wingtip."""
    if state == "up":
        return np.array([[x_f, y_f + b * r_f, z_f + h_f / 2], [x_f, y_f - b * r_f, z_f + h_f / 2]])
    return np.array([[x_f, y_f + b, z_f - h_f / 2], [x_f, y_f - b, z_f - h_f / 2]])


def wake_induced_force(leader, follower, bird):
    """Return F_uu, F_ud, F_du and F_dd in a dict, each a vector, the leader's state named first.

    Parameters
    ----------
    leader : tuple
        x_L, y_L, z_L, h_L, R_L.
    follower : tuple
        x_F, y_F, z_F, h_F, R_F.
    bird : dict
        rho, b, U, T, circulation.
    """
    b, circulation = bird["b"], bird["circulation"]
    forces = {}
    for of_leader in ("up", "down"):
        wake = filaments(of_leader, *leader, b, bird["U"] * bird["T"])
        for of_follower in ("up", "down"):
            right, left = wingtips(of_follower, *follower, b)
            wind = velocity(right, wake, circulation, 0.171 * b) + velocity(
                left, wake, circulation, 0.171 * b
            )
            span = right[1] - left[1]
            forces[of_leader[0] + of_follower[0]] = (
                bird["rho"] * circulation * span / 2 * np.cross(wind, [0.0, 1.0, 0.0])
            )
    return forces


def phase_weights(kappa):
    """Return β of uu, ud, du and dd in a dict."""
    alike = abs(kappa - 1 / 2)
    unlike = 1 / 2 - abs(kappa - 1 / 2)
    return {"uu": alike, "dd": alike, "ud": unlike, "du": unlike}
