"""An experiment that writes down which cases it ran, for tests of `reproduce`."""

from pathlib import Path

from appliance.reproduction.experiment import Experiment, Plot, Section, Table


class CountedExperiment(Experiment):
    """Squares of numbers."""

    name = "squares"

    def __init__(self, log: Path):
        self._log = log

    def cases(self, *, quick):
        return [{"value": value} for value in range(2 if quick else 4)]

    def run(self, case):
        with self._log.open("a") as file:
            file.write(f"{case['value']}\n")
        return {"square": case["value"] ** 2}

    def section(self, results):
        squares = [result["square"] for _, result in results]
        rows = [(str(case["value"]), str(result["square"])) for case, result in results]
        plot = Plot("squares", "All", Drawn(squares))
        return Section(
            "Squares <of numbers>", "None.", [Table("Squares", ("", "square"), rows)], [plot], ["They grow."]
        )


class Drawn:
    def __init__(self, values):
        self._values = values

    def __call__(self, axes):
        axes.plot(self._values, label="square")
