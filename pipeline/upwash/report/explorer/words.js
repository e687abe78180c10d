// Numbers and places in words.
"use strict";

function makeWords({ state, semispan }) {
  const number = (value, digits) => {
    const text = value.toFixed(digits);
    return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
  };
  const metres = (value) => `${number(value, Math.abs(value) < 0.995 && semispan() < 0.4 ? 3 : 2)}\u00a0m`;
  const percent = (share, digits = 1) => `${number(100 * share, digits)}\u00a0%`;
  const sideWords = (y) => Math.abs(y) < 0.005 * semispan() ? "in line" : `${metres(Math.abs(y))} to the ${y < 0 ? "left" : "right"}`;
  const heightWords = (z) => Math.abs(z) < 0.005 * semispan() ? "level" : `${metres(Math.abs(z))} ${z < 0 ? "below" : "above"}`;
  const placeWords = () => `${metres(state.x)} behind, ${sideWords(state.y)}, ${heightWords(state.z)}.`;

  return { number, metres, percent, sideWords, heightWords, placeWords };
}
