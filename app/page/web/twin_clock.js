// The twin's stream counts its time from its own start. Both streams have each measured position, the twin as
// `measured_um`, the controller as `position_um`: the shift with which these agree is the difference of the clocks.

const compared = 240; // rows
const reach = 120; // rows, to each side of where the newest rows are
const leastMotion_um = 0.05;

/** The time to add to the twin's page times, or null where the stage does not move enough to tell. */
export function shiftOfTwin(controller, twin) {
  for (let axis = 0; axis < Math.min(controller.axes.length, twin.axes.length); ++axis) {
    const shift = shiftOfAxis(controller.axes[axis], twin.axes[axis]);
    if (shift !== null) return shift;
  }
  return null;
}

function shiftOfAxis(ours, theirs) {
  const needed = compared + 2 * reach;
  if (ours.end - ours.first < needed || theirs.end - theirs.first < needed) return null;
  const position = ours.columns.get('position_um');
  const measured = theirs.columns.get('measured_um');
  const at = ours.end - reach - compared;
  let [low, high] = [Infinity, -Infinity];
  for (let row = at; row < at + compared; ++row) {
    low = Math.min(low, position[row & ours.mask]);
    high = Math.max(high, position[row & ours.mask]);
  }
  if (!(high - low > leastMotion_um)) return null;
  let [best, least] = [0, Infinity];
  for (let shift = -reach; shift <= reach; ++shift) {
    let sum = 0;
    for (let row = 0; row < compared && sum < least; ++row) {
      const away =
        position[(at + row) & ours.mask] - measured[(theirs.end - reach - compared + row + shift) & theirs.mask];
      if (away === away) sum += Math.abs(away);
    }
    if (sum < least) [best, least] = [shift, sum];
  }
  return ours.time[at & ours.mask] - theirs.time[(theirs.end - reach - compared + best) & theirs.mask];
}
