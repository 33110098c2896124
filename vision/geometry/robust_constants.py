"""Constants of robust estimation that several fits share."""

BIWEIGHT_TUNING = 4.685  # Tukey's biweight, 95 % efficient on Gaussian noise (doi:10.1080/00401706.1974.10489171)
SIGMA_PER_MAD = 1.4826  # standard deviation of Gaussian noise over its median absolute deviation, 1 / Phi^-1(3/4)
