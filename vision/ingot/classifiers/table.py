"""The table of classifiers: how each judges a face."""

from vision.ingot.classifiers.classifier import FaceClassifier
from vision.ingot.classifiers.names import ClassifierName
from vision.ingot.classifiers.relief import ReliefOdds
from vision.ingot.classifiers.ssim import DualSimilarity, SingleSimilarity
from vision.ingot.classifiers.wrinkles import WrinkleOdds

CLASSIFIERS: dict[ClassifierName, type[FaceClassifier]] = {
    "relief": ReliefOdds,
    "wrinkles": WrinkleOdds,
    "dual": DualSimilarity,
    "single": SingleSimilarity,
}
