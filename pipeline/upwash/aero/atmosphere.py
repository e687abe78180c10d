"""The standard atmosphere up to the tropopause: density and viscosity of the air in which a bird flies.

Air is told by its density alone, as everywhere in the model; what else is asked of it is that of the standard
atmosphere where it is as dense.
"""

from __future__ import annotations

SEA_LEVEL_TEMPERATURE_K = 288.15
"""Temperature at sea level, in K (ISO 2533:1975)."""

SEA_LEVEL_PRESSURE_PA = 101325.0
"""Pressure at sea level, in Pa (ISO 2533:1975)."""

LAPSE_RATE_K_M = 0.0065
"""By how much it grows colder with height, in K/m, up to the tropopause (ISO 2533:1975)."""

GAS_CONSTANT_J_KG_K = 287.05287
"""Specific gas constant of dry air, in J/(kg K) (ISO 2533:1975)."""

STANDARD_GRAVITY_M_S2 = 9.80665
"""Gravitational acceleration that the atmosphere is computed with, in m/s² (ISO 2533:1975)."""

CEILING_M = 11000.0
"""Geopotential altitude of the tropopause, in m, up to which the atmosphere is told here (ISO 2533:1975)."""

SUTHERLAND_KG_M_S_K = 1.458e-6
SUTHERLAND_TEMPERATURE_K = 110.4
"""Constants of Sutherland's formula for the viscosity of air, in kg/(m s √K) and in K (ISO 2533:1975)."""

_PRESSURE_EXPONENT = STANDARD_GRAVITY_M_S2 / (GAS_CONSTANT_J_KG_K * LAPSE_RATE_K_M)
_SEA_LEVEL_DENSITY = SEA_LEVEL_PRESSURE_PA / (GAS_CONSTANT_J_KG_K * SEA_LEVEL_TEMPERATURE_K)


def temperature_k(altitude_m: float) -> float:
    """Temperature, in K, at a geopotential altitude from 0 to `CEILING_M`, in m."""
    return SEA_LEVEL_TEMPERATURE_K - LAPSE_RATE_K_M * altitude_m


def density_kg_m3(altitude_m: float) -> float:
    """Density of the air, in kg/m³, at a geopotential altitude from 0 to `CEILING_M`, in m.

    Raises
    ------
    ValueError
        If the altitude is below sea level or above the tropopause.

    Examples
    --------
    >>> round(density_kg_m3(0.0), 4), round(density_kg_m3(5000.0), 4)
    (1.225, 0.7361)
    """
    if not 0.0 <= altitude_m <= CEILING_M:
        raise ValueError(f"altitude_m: expected 0 to {CEILING_M:g}, the tropopause, found {altitude_m!r}")
    ratio = temperature_k(altitude_m) / SEA_LEVEL_TEMPERATURE_K
    return float(_SEA_LEVEL_DENSITY * ratio ** (_PRESSURE_EXPONENT - 1.0))


def viscosity_kg_m_s(density: float) -> float:
    """Dynamic viscosity, in kg/(m s), where the standard atmosphere has a density in kg/m³.

    Examples
    --------
    >>> f"{viscosity_kg_m_s(density_kg_m3(0.0)):.4g}"
    '1.789e-05'
    """
    ratio = (density / _SEA_LEVEL_DENSITY) ** (1.0 / (_PRESSURE_EXPONENT - 1.0))
    temperature = SEA_LEVEL_TEMPERATURE_K * ratio
    return float(SUTHERLAND_KG_M_S_K * temperature**1.5 / (temperature + SUTHERLAND_TEMPERATURE_K))
