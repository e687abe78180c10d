"""Velocity induced by straight vortex filaments with a Rankine core, and its gradient: compiled.

Outside its core a finite filament induces the Biot–Savart velocity; within, the fluid turns as a solid body.
With the filament a = r₂ − r₁ and the point at b from r₁ and c from r₂ both are

    v = Γ/4π · (a × b) · a·(b/|b| − c/|c|) / max(|a × b|², r_c² |a|²),

continuous everywhere, and not differentiable where the two arguments of the maximum meet: the core edge.
"""

from __future__ import annotations

import math

import numpy as np

from upwash.kernel import kernel

FOUR_PI = 4.0 * math.pi

# |b|² is never less than this much of the squared core radius.  The velocity at a filament's end is zero,
# since a × b is; the floor only keeps 0/0 from being formed there, and changes no digit a millionth of a core
# away.
END_FLOOR = 1e-24

# Sums may be reordered and multiplications fused, which lets the compiler fill its vector registers; what a
# result means (signed infinities, not-a-number) stays as the language says.
FAST = {"contract", "reassoc", "nsz"}


@kernel(fastmath=FAST)
def filament_velocity(
    point_x, point_y, point_z, start_x, start_y, start_z, end_x, end_y, end_z, circulation, core_radius
):
    """Return the velocity induced by one filament at one point (v_ind), inside the core and out.

    Parameters
    ----------
    point_x, point_y, point_z : float
        The point, in m.
    start_x, start_y, start_z, end_x, end_y, end_z : float
        Ends r₁ and r₂ of the filament, in m; circulation is right-handed from the first to the second.
    circulation : float
        Signed circulation, in m²/s.
    core_radius : float
        Radius of the core, in m.

    Returns
    -------
    tuple of float
        Velocity (x, y, z), in m/s.
    """
    along_x, along_y, along_z = end_x - start_x, end_y - start_y, end_z - start_z
    from_start_x, from_start_y, from_start_z = point_x - start_x, point_y - start_y, point_z - start_z
    from_end_x, from_end_y, from_end_z = point_x - end_x, point_y - end_y, point_z - end_z
    length2 = along_x * along_x + along_y * along_y + along_z * along_z
    floor = END_FLOOR * core_radius * core_radius
    start_distance = math.sqrt(from_start_x**2 + from_start_y**2 + from_start_z**2 + floor)
    end_distance = math.sqrt(from_end_x**2 + from_end_y**2 + from_end_z**2 + floor)
    cross_x = along_y * from_start_z - along_z * from_start_y
    cross_y = along_z * from_start_x - along_x * from_start_z
    cross_z = along_x * from_start_y - along_y * from_start_x
    cosines = (along_x * from_start_x + along_y * from_start_y + along_z * from_start_z) / start_distance - (
        along_x * from_end_x + along_y * from_end_y + along_z * from_end_z
    ) / end_distance
    outside = cross_x * cross_x + cross_y * cross_y + cross_z * cross_z
    inside = core_radius * core_radius * length2
    factor = circulation / FOUR_PI * cosines / (outside if outside > inside else inside)
    return factor * cross_x, factor * cross_y, factor * cross_z


@kernel(fastmath=FAST, inline="always")
def ring_velocity_gradient(
    point_x,
    point_y,
    point_z,
    first_x,
    last_x,
    first_z,
    last_z,
    half_width,
    along_x,
    along_z,
    core2,
    edge_first,
    edge_last,
    edge_left,
    edge_right,
):
    """Return velocity and gradient of a tilted rectangle of unit circulation over 4π, centred on y = 0.

    The sum of its four filaments, written out: the spanwise ones lie along y and the tip filaments in planes
    of constant y, so few products remain, and neighbouring filaments share the distance to their corner.

    Parameters
    ----------
    point_x, point_y, point_z : float
        The point, in m.
    first_x, last_x, first_z, last_z : float
        x and z of the starting and of the stopping vortex, in m.
    half_width : float
        Half the length of the spanwise filaments, in m.
    along_x, along_z : float
        Unit vector from the first to the last station.
    core2 : float
        Square of the core radius, in m².
    edge_first, edge_last, edge_left, edge_right : float
        Squared distance to the starting, the stopping, the left and the right tip filament beyond which the
        outer branch holds, in m².  With `core2` the field is the Rankine core's; any other value continues
        one branch past the core edge (−1: the outer everywhere, infinity: the inner), which is smooth where
        the field is not.

    Returns
    -------
    tuple of 12 float
        Velocity (x, y, z) and its derivatives, row by row: vx by x, y, z; vy by x, y, z; vz by x, y, z.  On a
        core edge the derivatives are those from inside.
    """
    floor = END_FLOOR * core2
    x0, x1, z0, z1 = point_x - first_x, point_x - last_x, point_z - first_z, point_z - last_z
    yl, yr = point_y + half_width, point_y - half_width
    yl2, yr2 = yl * yl, yr * yr
    q0, q1 = x0 * x0 + z0 * z0, x1 * x1 + z1 * z1
    d = along_z * x0 - along_x * z0
    rl, rr = yl2 + d * d, yr2 + d * d
    n0l, n0r = math.sqrt(q0 + yl2 + floor), math.sqrt(q0 + yr2 + floor)
    n1l, n1r = math.sqrt(q1 + yl2 + floor), math.sqrt(q1 + yr2 + floor)
    m0, m1 = (q0 if q0 > edge_first else core2), (q1 if q1 > edge_last else core2)
    ml, mr = (rl if rl > edge_left else core2), (rr if rr > edge_right else core2)
    # One division gives all reciprocals: of the distances to the corners (i) and of the squared distances to
    # the filaments, no less than the core's (g).
    n0, n1, m01, mlr = n0l * n0r, n1l * n1r, m0 * m1, ml * mr
    per_n, per_m = n0 * n1, m01 * mlr
    per_all = 1.0 / (per_n * per_m)
    per_n, per_m = per_all * per_m, per_all * per_n
    per_n0, per_n1, per_m01, per_mlr = per_n * n1, per_n * n0, per_m * mlr, per_m * m01
    i0l, i0r, i1l, i1r = per_n0 * n0r, per_n0 * n0l, per_n1 * n1r, per_n1 * n1l
    g0, g1, gl, gr = per_m01 * m1, per_m01 * m0, per_mlr * mr, per_mlr * ml
    c0l, c0r, c1l, c1r = i0l * i0l * i0l, i0r * i0r * i0r, i1l * i1l * i1l, i1r * i1r * i1r
    # Spanwise filaments: starting at the first station, stopping (reversed) at the last.
    out0, out1 = (2.0 if q0 > edge_first else 0.0), (2.0 if q1 > edge_last else 0.0)
    s0, s1 = yl * i0l - yr * i0r, yl * i1l - yr * i1r
    f0, f1 = s0 * g0, s1 * g1
    h0 = (yr * c0r - yl * c0l) * g0 - out0 * f0 * g0
    h1 = (yr * c1r - yl * c1l) * g1 - out1 * f1 * g1
    fy0, fy1 = q0 * (c0l - c0r) * g0, q1 * (c1l - c1r) * g1
    # Tip filaments: right along the run, left against it; both see the same distance from their common plane.
    ax, az = along_x, along_z
    p0, p1 = ax * x0 + az * z0, ax * x1 + az * z1
    outl, outr = (2.0 if rl > edge_left else 0.0), (2.0 if rr > edge_right else 0.0)
    sl, sr = p0 * i0l - p1 * i1l, p0 * i0r - p1 * i1r
    fl, fr = sl * gl, sr * gr
    hl, hr = outl * fl * gl, outr * fr * gr
    p0l, p1l, p0r, p1r = p0 * c0l, p1 * c1l, p0 * c0r, p1 * c1r
    flx = (ax * (i0l - i1l) - (p0l * x0 - p1l * x1)) * gl - hl * d * az
    frx = (ax * (i0r - i1r) - (p0r * x0 - p1r * x1)) * gr - hr * d * az
    flz = (az * (i0l - i1l) - (p0l * z0 - p1l * z1)) * gl + hl * d * ax
    frz = (az * (i0r - i1r) - (p0r * z0 - p1r * z1)) * gr + hr * d * ax
    fly = -yl * ((p0l - p1l) * gl + hl)
    fry = -yr * ((p0r - p1r) * gr + hr)
    tip = yr * fr - yl * fl
    tip_x, tip_z = yr * frx - yl * flx, yr * frz - yl * flz
    tip_y = fr + yr * fry - fl - yl * fly
    twist = fr - fl
    return (
        z0 * f0 - z1 * f1 - az * tip,
        d * twist,
        x1 * f1 - x0 * f0 + ax * tip,
        z0 * x0 * h0 - z1 * x1 * h1 - az * tip_x,
        z0 * fy0 - z1 * fy1 - az * tip_y,
        f0 + z0 * z0 * h0 - f1 - z1 * z1 * h1 - az * tip_z,
        az * twist + d * (frx - flx),
        d * (fry - fly),
        d * (frz - flz) - ax * twist,
        f1 + x1 * x1 * h1 - f0 - x0 * x0 * h0 + ax * tip_x,
        x1 * fy1 - x0 * fy0 + ax * tip_y,
        x1 * z1 * h1 - x0 * z0 * h0 + ax * tip_z,
    )


@kernel(fastmath=FAST)
def _add_ring_velocity(x, y, z, ring, circulation, core2, velocity_x, velocity_y, velocity_z):
    """Add one ring's velocity at many points: `ring_velocity_gradient` without the gradient."""
    floor = END_FLOOR * core2
    first_x, last_x, first_z, last_z, centre_y, half_width = ring
    run_x, run_z = last_x - first_x, last_z - first_z
    per_run = 1.0 / math.sqrt(run_x * run_x + run_z * run_z)
    ax, az = run_x * per_run, run_z * per_run
    strength = circulation / FOUR_PI
    for i in range(x.size):
        x0, x1, z0, z1 = x[i] - first_x, x[i] - last_x, z[i] - first_z, z[i] - last_z
        yl, yr = y[i] - centre_y + half_width, y[i] - centre_y - half_width
        yl2, yr2 = yl * yl, yr * yr
        q0, q1 = x0 * x0 + z0 * z0, x1 * x1 + z1 * z1
        n0l, n0r = math.sqrt(q0 + yl2 + floor), math.sqrt(q0 + yr2 + floor)
        n1l, n1r = math.sqrt(q1 + yl2 + floor), math.sqrt(q1 + yr2 + floor)
        d = az * x0 - ax * z0
        p0, p1 = ax * x0 + az * z0, ax * x1 + az * z1
        rl, rr = yl2 + d * d, yr2 + d * d
        m0, m1 = (q0 if q0 > core2 else core2), (q1 if q1 > core2 else core2)
        ml, mr = (rl if rl > core2 else core2), (rr if rr > core2 else core2)
        # One division serves all four filaments: its share is the product of the other three denominators.
        b0, b1, bl, br = n0l * n0r * m0, n1l * n1r * m1, n0l * n1l * ml, n0r * n1r * mr
        spans, tips = b0 * b1, bl * br
        quotient = strength / (spans * tips)
        per_spans, per_tips = quotient * tips, quotient * spans
        f0, f1 = (yl * n0r - yr * n0l) * b1 * per_spans, (yl * n1r - yr * n1l) * b0 * per_spans
        fl, fr = (p0 * n1l - p1 * n0l) * br * per_tips, (p0 * n1r - p1 * n0r) * bl * per_tips
        tip = yr * fr - yl * fl
        velocity_x[i] += z0 * f0 - z1 * f1 - az * tip
        velocity_y[i] += d * (fr - fl)
        velocity_z[i] += x1 * f1 - x0 * f0 + ax * tip


# Points are taken in blocks: their coordinates, sorted into one row each, and their velocities then stay in
# the first-level cache while all rings act on them, and the loop above fills whole vector registers.
BLOCK = 512


@kernel
def _fill_block(
    points, rings, circulation, core_radius, x, y, z, velocity_x, velocity_y, velocity_z, velocity
):
    """Overwrite one block's velocity, working in six rows as long as the block."""
    for i in range(points.shape[0]):
        x[i], y[i], z[i] = points[i, 0], points[i, 1], points[i, 2]
        velocity_x[i] = velocity_y[i] = velocity_z[i] = 0.0
    for k in range(circulation.size):
        ring = (rings[k, 0], rings[k, 1], rings[k, 2], rings[k, 3], rings[k, 4], rings[k, 5])
        core2 = core_radius[k] * core_radius[k]
        _add_ring_velocity(x, y, z, ring, circulation[k], core2, velocity_x, velocity_y, velocity_z)
    for i in range(points.shape[0]):
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = velocity_x[i], velocity_y[i], velocity_z[i]


@kernel
def fill_velocity(points, rings, circulation, core_radius, velocity):
    """Overwrite an array with the velocity of rings at points; `velocity` for compiled loops and threads.

    The interpreter's lock is released meanwhile, so threads may fill slices of one array at the same time.

    Parameters
    ----------
    points : (p, 3) ndarray of float
        Points, in m.
    rings : (n, 6) ndarray of float
        Tilted rectangles as in `upwash.aero.wake.Wake`, in m.
    circulation : (n,) ndarray of float
        Circulation of each ring, in m²/s.
    core_radius : (n,) ndarray of float
        Radius of the cores of each ring's filaments, in m.
    velocity : (p, 3) ndarray of float
        Overwritten, in m/s.
    """
    room = np.empty((6, min(BLOCK, points.shape[0])))
    for first in range(0, points.shape[0], BLOCK):
        block = points[first : first + BLOCK]
        size = block.shape[0]
        _fill_block(
            block,
            rings,
            circulation,
            core_radius,
            room[0, :size],
            room[1, :size],
            room[2, :size],
            room[3, :size],
            room[4, :size],
            room[5, :size],
            velocity[first : first + BLOCK],
        )


@kernel(error_model="python")
def add_velocity_gradient(points, rings, circulation, core_radius, gradient):
    """Add to an array the gradient of the velocity of rings at points; on a core edge, that from inside the core.

    Parameters
    ----------
    points, rings, circulation, core_radius
        As for `fill_velocity`.
    gradient : (p, 9) ndarray of float
        Added to, in 1/s: derivatives row by row, as those of `ring_velocity_gradient`.
    """
    for i in range(points.shape[0]):
        for k in range(circulation.size):
            core2 = core_radius[k] * core_radius[k]
            run = math.hypot(rings[k, 1] - rings[k, 0], rings[k, 3] - rings[k, 2])
            found = ring_velocity_gradient(
                points[i, 0],
                points[i, 1] - rings[k, 4],
                points[i, 2],
                rings[k, 0],
                rings[k, 1],
                rings[k, 2],
                rings[k, 3],
                rings[k, 5],
                (rings[k, 1] - rings[k, 0]) / run,
                (rings[k, 3] - rings[k, 2]) / run,
                core2,
                core2,
                core2,
                core2,
                core2,
            )
            for j in range(9):
                gradient[i, j] += circulation[k] / FOUR_PI * found[3 + j]
