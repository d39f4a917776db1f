// Discs on a shaft that turn as the package computed it for each setting of the controls.
import {disc, twist} from "./discs.js";
import {define, nearest, round} from "./kit.js";
import {Mover, series} from "./mover.js";
import {picture} from "./plot.js";

const [LEFT, RIGHT, LARGEST] = [52, 288, 42];  // the outer discs, and the size of the heaviest
const GROWN = 0.9;                             // rad, of the largest angle

class Shaft extends Mover {
  get horizon() { return this.data.seconds; }
  get pace() { return this.data.pace; }

  markup() {
    this.figures = this.data.captions;
    this.snaps = Object.keys(this.data.grids);
    return super.markup();
  }

  // What was computed for these values of the controls.
  compute(place) {
    const at = this.data.controls.reduce((k, {key, names}) => {
      const grid = this.data.grids[key];
      return k * grid.length + (names ? place[key] : nearest(grid, place[key]));
    }, 0);
    return this.data.settings[at];
  }

  show({state, words, line, rules = []}, ghost) {
    const [first, ...more] = words;
    this.tell(state, first, more.map(text => `<p>${text}</p>`).join(""));
    if (!line) return;
    const T = this.horizon / (line.length - 1), [label, y] = this.data.axis;
    this.curves("curve", label, `${label} over time`, [{points: series(line, T)}],
      {y, rules, ghosts: ghost ? [{points: series(ghost.line, T)}] : []});
  }

  pose(result, time) {
    super.pose(result, time);
    const {turns, pale = []} = result, last = turns[0].length - 1;
    const k = Math.round(time / this.horizon * last);
    const grown = this.data.axis ? this.data.settings : [result];  // with a line: at one scale
    const most =
      Math.max(...grown.flatMap(one => [...one.turns, ...(one.pale ?? [])].flat()).map(Math.abs)) || 1;
    const at = values => values[k] * GROWN / most;
    const x = i => round(LEFT + (RIGHT - LEFT) * i / (turns.length - 1));
    const size = i => LARGEST * this.data.sizes[i];
    const shaft = turns.slice(1).map(
      (turn, i) => twist([x(i), at(turns[i])], [x(i + 1), at(turn)], Math.ceil(24 / turns.length)));
    const names =
      this.data.names.map(([i, name]) => `<text x="${x(i)}" y="134" text-anchor="middle">${name}</text>`);
    this.find("scene").innerHTML = picture(144, `A shaft with ${turns.length} discs`,
      shaft.join("") + turns.map((turn, i) => disc(x(i), size(i), at(turn))).join("") +
        pale.map((turn, i) => disc(x(i), size(i), at(turn), true)).join("") + names.join(""));
  }
}

define("sos-shaft", Shaft);
