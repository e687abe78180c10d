// The physics of the explorer: birds, wakes and balances, put together. It knows no page, so that a worker can run it too.
"use strict";

function makePhysics(constants) {
  const birds = makeBirds(constants), wakes = { paper: makePaperWakes(constants), limit: makeEndlessWakes(constants) };

  // Return the function that writes lift and thrust of a leader's wake on a follower, in N, to `force`: in its whole
  // wingbeat, or in the part of it that is named.
  const makeWake = (bird, model) => wakes[model.name](bird, model);

  return { ...birds, makeWake, ...makeBalances(constants, birds) };
}

// All that a worker needs to run it.
const PHYSICS = [makeBirds, makePaperWakes, makeEndlessWakes, makeBalances, makePhysics];
