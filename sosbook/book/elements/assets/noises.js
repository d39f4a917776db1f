import {define} from "./kit.js";
import {Mover, number} from "./mover.js";

class Noises extends Mover {
  says = "The motor's encoder has a noise of {motor}, the load's one of {load}.";
  snaps = ["motor", "load"];
  figures = {
    norm: "Least norm: solid the load's encoder alone, dashed the motor's, dotted both; the mark is here."
  };

  // The place of a noise on the grid.
  node(noise) { return this.data.grid.findIndex(x => x > 0.99 * noise); }

  compute({motor, load}) {
    const {least} = this.data, [i, j] = [this.node(motor), this.node(load)];
    return {motor: least.motor[i], load: least.load[j], both: least.both[i][j], row: least.both[i]};
  }

  show({motor, load, both, row}, _, place) {
    const {grid, least} = this.data, better = load < motor ? "load" : "motor";
    const log = values => values.map((x, k) => [Math.log10(grid[k]), Math.log10(x)]);
    const unit = " rad per N m", gain = 100 * (1 - both / Math.min(load, motor));
    this.tell(better === "load" ? "feasible" : "infeasible", `The ${better}'s encoder is the better one.`,
      `<p>Motor's alone ${number(motor, unit)}, load's alone ${number(load, unit)}, both ${
        number(both, unit)}: a second encoder saves ${number(gain, " %", 2)}.</p>`);
    this.curves("norm", ["log₁₀ of the load's noise in rad", "log₁₀ of the norm"],
      "Least norm over the load's noise",
      [
        {points: log(grid.map(() => motor)), dash: "6 4", colour: "--sos-second"},
        {points: log(row), dash: "2 3", colour: "--sos-third"}, {points: log(least.load)}
      ],
      {
        x: [-3, -1],
        y: [-1.15, -0.55],
        marks: [[[Math.log10(place.load), Math.log10(load)], "--sos-first", 1]]
      });
  }
}

define("sos-noises", Noises);
