"""Judges faces by two references, with the classifier and the comparison that are in use."""

from vision.ingot.classifiers.classifier import Face, FaceClassifier, Picture, Verdict
from vision.ingot.classifiers.names import ClassifierName
from vision.ingot.classifiers.similarity import USUAL_COMPARISON, Comparison, as_reference, circular, similarity
from vision.ingot.classifiers.ssim import SingleSimilarity
from vision.ingot.classifiers.table import CLASSIFIERS


class FaceJudge:
    """A classifier with its references.

    Parameters
    ----------
    references : tuple of ndarray of uint8
        Top and bottom, any size, grey or blue-green-red.
    classifier : str
        One of `CLASSIFIERS`.
    comparison : Comparison
        How similarities with the references are computed.

    Raises
    ------
    ValueError
        `classifier` is not in the table, or a reference has no picture's shape.
    """

    def __init__(
        self,
        references: tuple[Picture, Picture],
        classifier: ClassifierName,
        comparison: Comparison = USUAL_COMPARISON,
    ) -> None:
        if classifier not in CLASSIFIERS:
            raise ValueError(f"classifier is {classifier!r}; allowed are {', '.join(CLASSIFIERS)}")
        self._references = as_reference(references[0]), as_reference(references[1])
        self._comparison = comparison
        kind = CLASSIFIERS[classifier]
        self._classifier: FaceClassifier = (
            SingleSimilarity(*self._references, comparison.threshold)
            if kind is SingleSimilarity
            else kind(*self._references)
        )

    def face(self, image: Picture) -> Face:
        """An end with its similarities to both references.

        Parameters
        ----------
        image : ndarray of uint8, shape (64, 64)
            As `end_image` gives it.
        """
        return Face(image, *(self._similarity(image, reference) for reference in self._references))

    def verdict(self, face: Face) -> Verdict:
        """Which end a face is, and how sure that is."""
        return self._classifier.judge(face)

    def clearness(self, face: Face) -> float:
        """How clear a face is; see `FaceClassifier`."""
        return self._classifier.clearness(face)

    def _similarity(self, image: Picture, reference: Picture) -> float:
        if self._comparison.circular:
            image, reference = circular(image), circular(reference)
        return similarity(image, reference, self._comparison.exponents)
