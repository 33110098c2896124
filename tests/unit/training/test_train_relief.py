"""The network of relief: its slopes are those of its loss, it learns what it is shown, and training repeats itself."""

import json

import numpy as np
import pytest

from appliance.files.digest import file_sha256
from appliance.simulation.ingots.cast_faces import cast_face
from appliance.simulation.ingots.faces import LABELS
from appliance.training import relief_batches
from appliance.training.ingot_relief import PLAN, RATE, SAMPLE, SEED, described, main, train, trained, write
from appliance.training.relief_batches import Batch, batch_of, layered, without_flat_tops
from appliance.training.relief_slopes import CERTAINTY, first_layers, loss_and_slopes
from appliance.training.rendered_ends import RenderedLine, random_camera, rendered_end, rendered_line
from vision.ingot.classifiers.classifier import Face
from vision.ingot.classifiers.relief import MODEL, ReliefOdds, relief

SIDE = 64


def log_odds(judge, image):
    return judge.judge(Face(image, 0.0, 0.0)).log_odds


def test_slopes_are_those_of_the_loss():
    rng = np.random.default_rng(0)
    layers = [(weights.astype(np.float64), bias + 0.1) for weights, bias in first_layers(rng)]
    batch = Batch(rng.standard_normal((6, SIDE, SIDE, 3)), np.array([2, 4]), np.array([3, 3]), np.array([0.0, 1.0]))
    _, slopes = loss_and_slopes(layers, batch)
    parameters = [one for pair in layers for one in pair]
    for one, slope in zip(parameters, slopes, strict=True):
        assert slope.shape == one.shape
        place = np.unravel_index(np.argmax(np.abs(slope)), one.shape)
        losses = []
        for step in (1e-6, -2e-6):
            one[place] += step
            losses.append(loss_and_slopes(layers, batch)[0])
        one[place] += 1e-6
        assert (losses[0] - losses[1]) / 2e-6 == pytest.approx(slope[place], rel=1e-2)


def test_what_is_trained_is_what_is_served():
    rng = np.random.default_rng(3)
    layers = first_layers(rng)
    quarters = rng.integers(60, 200, (3, SIDE // 2, SIDE // 2)).astype(np.uint8)
    top, bottom, end = np.pad(quarters, ((0, 0), (0, SIDE // 2), (0, SIDE // 2)), "symmetric")  # own mirror images
    odds = log_odds(ReliefOdds(top, bottom, layers), end)
    planes = np.stack([relief(image) for image in (end, top, bottom)])
    batch = Batch(planes, np.array([1]), np.array([2]), np.array([1.0], np.float32))
    share = CERTAINTY + (1 - CERTAINTY) / 2
    entropy = share * np.logaddexp(0, -odds) + (1 - share) * np.logaddexp(0, odds)
    assert loss_and_slopes(layers, batch)[0] == pytest.approx(entropy, rel=1e-4)


def test_tops_that_show_no_more_than_flat_bottoms_are_left_out():
    rng = np.random.default_rng(6)
    line = line_of_bars(rng)
    flat = line._replace(ends=np.where(line.tops[:, None, None], np.uint8(120), line.ends))
    assert len(without_flat_tops(flat, 0.0).ends) == len(without_flat_tops(line, 0.05).ends) == len(line.ends)
    assert without_flat_tops(flat, 0.05).tops.tolist() == [False] * 3


def test_blemishes_of_a_bottom_are_laid_on_ends_and_never_stronger_than_a_tops_own_relief():
    rng = np.random.default_rng(4)
    ends = np.concatenate([rng.normal(0, (1, 1, 0), (8, SIDE, SIDE, 3)), rng.normal(0, (5, 5, 0), (8, SIDE, SIDE, 3))])
    ends[..., 2] = 1
    ends[8:, :8] = 0  # glare on the bottoms
    tops = np.arange(16) < 8
    ends = ends.astype(np.float32)
    both = layered(ends, tops, rng)
    changed = np.flatnonzero((both != ends).any(axis=(1, 2, 3)))
    assert 0 < len(changed) < 16
    for number in changed:
        added = (both[number] - ends[number])[8:, ..., 0].std()
        assert added <= (1.1 if tops[number] else 5.1)
        assert not both[number, :8].any()
    assert (layered(ends[:8], tops[:8], rng) == ends[:8]).all()


def line_of_bars(rng):
    """A line whose tops show a dark bar."""
    tops = np.arange(6) % 2 == 0
    ends = rng.normal(120, 3, (8, SIDE, SIDE))
    ends[np.append([True, False], tops), 28:34, 16:48] -= 40
    ends = ends.astype(np.uint8)
    return RenderedLine(ends[:2], ends[2:], tops)


@pytest.fixture
def small_batches(monkeypatch):
    monkeypatch.setattr(relief_batches, "LINES_A_BATCH", 6)


@pytest.mark.usefixtures("small_batches")
def test_it_learns_what_tops_of_its_lines_have_in_common():
    rng = np.random.default_rng(1)
    lines = [line_of_bars(rng) for _ in range(20)]
    layers = first_layers(rng)
    train(layers, lines, 25, rng)
    loss, _ = loss_and_slopes(layers, batch_of(lines, rng))
    assert loss < 0.3


def test_the_shipped_file_is_the_one_of_its_record_and_training_today_begins_as_it_did(tmp_path):
    record = json.loads(MODEL.with_suffix(".json").read_text(encoding="utf-8"))
    assert file_sha256(MODEL) == record["sha256"]
    assert MODEL.stat().st_size < 1_000_000
    assert (record["seed"], record["steps"], record["rate"]) == (SEED, PLAN.steps, RATE)
    assert record["line_sets"] == [described(one) for one in PLAN.line_sets]
    runs = [trained(SAMPLE) for _ in range(2)]
    assert runs[0].losses == pytest.approx(record["sample_losses"], rel=1e-3)
    for name, run in zip(("first.npz", "second.npz"), runs, strict=True):
        write(run.layers, tmp_path / name)
    assert (tmp_path / "first.npz").read_bytes() == (tmp_path / "second.npz").read_bytes()


def test_a_folder_that_is_missing_is_told_before_the_training(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["ingot_relief", "--output", str(tmp_path / "none" / "relief.npz")])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 2
    assert "no such folder; make it first" in capsys.readouterr().err


def test_the_network_that_is_shipped_tells_ends_of_lines_it_has_not_seen():
    right = []
    for number in range(12):
        line = rendered_line(np.random.default_rng([424242, number]), faces=6, views=1)
        judge = ReliefOdds(*line.references)
        right += [(log_odds(judge, end) > 0) == top for end, top in zip(line.ends, line.tops, strict=True)]
    assert np.mean(right) >= 0.9


def test_the_network_that_is_shipped_tells_ends_of_a_kind_it_was_not_trained_on():
    right = []
    for number in range(12):
        rng = np.random.default_rng([434343, number])
        camera = random_camera(rng)
        *references, top, bottom = (rendered_end(cast_face(label, rng), camera, rng) for label in LABELS * 2)
        judge = ReliefOdds(*references)
        right += [log_odds(judge, top) > 0, log_odds(judge, bottom) < 0]
    assert np.mean(right) >= 0.9


def test_an_end_and_its_mirror_images_have_the_same_odds():
    line = rendered_line(np.random.default_rng(7), faces=2, views=1)
    judge, image = ReliefOdds(*line.references), line.ends[0]
    images = (image, image[::-1], image[:, ::-1], image[::-1, ::-1])
    odds = [judge.log_odds(np.ascontiguousarray(one)) for one in images]
    assert odds == pytest.approx([odds[0]] * 4, abs=1e-3)


def test_exposure_changes_no_relief_and_what_is_clipped_shows_none():
    rng = np.random.default_rng(5)
    image = np.clip(rng.normal(120, 8, (SIDE, SIDE)), 0, 255).astype(np.uint8)
    brighter = np.rint(1.2 * image).astype(np.uint8)
    assert relief(brighter)[..., :2] == pytest.approx(relief(image)[..., :2], abs=0.25)
    assert not relief(np.full((SIDE, SIDE), 255, np.uint8)).any()
