// A drive with the sensors that are ticked: its law, and its loop in floats or in decimals.
import {affine} from "./cells.js";
import {zeros} from "./linalg.js";

/** @type {(place: any, kind: string) => number[]} */
export const ticked = (place, kind) => [0, 1].filter(i => place[`${kind}${i + 1}`]);
/** @type {(N: number, at: number) => number[]} */
export const unit = (N, at) => Array.from({length: N}, (_, j) => j === at ? 1 : 0);

// What is measured: for each gain its name and a row of y, on x = [z; z'; integral; lagging
// angles]; and x' = A x of what the law remembers.
export function law({rates: filters, parts}, place) {
  const angles = ticked(place, "p"), rates = ticked(place, "v"), lagging = rates.length ? [] : angles;
  const a = filters[place.filter], sum = angles.length ? place.integral : 0;
  const N = 4 + sum + lagging.length, memory = zeros(N, N);
  /** @type {any[]} */
  const measured = [
    ...angles.map(i => ["K_P", unit(N, i)]), ...rates.map(i => ["K_D", unit(N, 2 + i)]),
    ...lagging.map((i, k) => ["K_D", Object.assign(unit(N, -1), {[i]: a, [4 + sum + k]: -a})]),
    ...(sum ? [["K_I", unit(N, 4)]] : [])
  ];
  lagging.forEach((i, k) => Object.assign(memory[4 + sum + k], {[i]: a, [4 + sum + k]: -a}));
  if (sum) memory[4][angles[0]] = 1;
  const push = [...zeros(2, 1), ...parts.B, ...zeros(N - 4, 1)];
  return {N, memory, push, names: measured.map(([name]) => name), rows: measured.map(([, row]) => row)};
}

// [E, A] of its loop with u = gains y for a load and a shaft, in floats or in decimals.
export function loop({parts}, {N, memory, push, rows}, gains) {
  return (point, ring) => {
    const {identity, matrix, place, combined, times} = ring;
    const [M, S] = [parts.M, parts.S].map(X => affine(X, point, ring));
    const E = place(identity(N), 2, 2, combined(1, M, -1, identity(2)));
    const A = place(matrix(memory), 0, 2, identity(2));
    place(place(A, 2, 0, S, -1), 2, 2, matrix(parts.D), -1);
    return [
      E, gains.length ? combined(1, A, 1, times(matrix(push), times(matrix([gains]), matrix(rows)))) : A
    ];
  };
}
