// How two pictures differ, in numbers and as a picture. Used by `kinora diff`, by the image tests and by benchmarks.
// Channels are matched by name and pixels by place; it judges nothing: thresholds belong to the caller.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "image/status.h"

namespace kinora::image {

struct CompareOptions {
  double valueThreshold = 0;          // a value differs when |a - b| is above it (NaN against a number always does)
  double relativeEpsilon = 1e-2;      // of the relative squared error (a - b)^2 / (b^2 + epsilon)
  std::vector<std::string> channels;  // empty: all that both have
  // Only these pixels: xmin, xmax, ymin, ymax in 0..1 of the pictures, as CropWindow.
  std::array<float, 4> part{0, 1, 0, 1};
};

struct Difference {
  uint64_t pixels = 0, values = 0;                    // compared
  uint64_t differingPixels = 0, differingValues = 0;  // beyond valueThreshold
  bool isBitEqual = false;                            // every value compared, NaN included, channels and windows
  uint64_t nanA = 0, nanB = 0;                        // values that are NaN
  uint64_t oneSidedNan = 0;                           // NaN in one only; they count as differing but enter no mean
  double rmse = 0;                                    // root of the mean squared error over all finite pairs
  double relativeMse = 0;                             // mean of the relative squared error, b the reference
  double meanA = 0, meanB = 0;
  double maximum = 0;  // largest |a - b|
  int maximumX = 0, maximumY = 0;
  std::string maximumChannel;
  std::vector<std::string> onlyA, onlyB;  // channels without a partner
};

// IMAGE-COMPARE when sizes differ or no channel is common.
Status compare(const Image& a, const Image& b, const CompareOptions& options, Difference& out);

// |a - b| of the common channels, times `gain`; a NaN on one side is shown as 1 x gain.
Status differencePicture(const Image& a, const Image& b, float gain, Image& out);

}  // namespace kinora::image
