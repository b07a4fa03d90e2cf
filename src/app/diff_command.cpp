// `kinora diff A B`.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "image/compare.h"
#include "image/read_write.h"

namespace kinora::app {

namespace {

struct Limits {
  double value = 0;                    // |a - b| up to which values are equal
  uint64_t pixels = 0;                 // that may differ
  double rmse = -1, relativeMse = -1;  // below 0: not asked
  bool isOver(const image::Difference& d, bool givenByValue) const {
    // a mean as the only limit replaces the limit by value, which would otherwise demand equality
    const bool byMean = rmse >= 0 || relativeMse >= 0;
    if ((givenByValue || !byMean) && d.differingPixels > pixels) return true;
    if (d.oneSidedNan > 0) return true;
    return (rmse >= 0 && !(d.rmse <= rmse)) || (relativeMse >= 0 && !(d.relativeMse <= relativeMse));
  }
};

void print(const image::Difference& d) {
  fmt::print("pixels            {}\n", d.pixels);
  fmt::print("differing pixels  {}\n", d.differingPixels);
  fmt::print("maximum           {:.6g}", d.maximum);
  if (d.maximum > 0) fmt::print("  at {},{} in {}", d.maximumX, d.maximumY, d.maximumChannel);
  fmt::print("\nRMSE              {:.6g}\nrelative MSE      {:.6g}\nmean              {:.6g} and {:.6g}\n", d.rmse,
             d.relativeMse, d.meanA, d.meanB);
  if (d.nanA || d.nanB) fmt::print("NaN values        {} and {}, {} in one only\n", d.nanA, d.nanB, d.oneSidedNan);
  for (const auto& [names, where] : {std::pair{&d.onlyA, "first"}, std::pair{&d.onlyB, "second"}})
    if (!names->empty()) fmt::print("only in the {}: {}\n", where, fmt::join(*names, " "));
  fmt::print("{}\n", d.isBitEqual ? "identical bit for bit" : "not identical");
}

}  // namespace

int runDiff(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser =
      makeParser("diff", "Compares two images of equal size; exit code 1 when they differ by more than allowed.");
  std::string fileA, fileB, output;
  Limits limits;
  image::CompareOptions options;
  double gain = 1;
  parser->add_option("A", fileA, "an image")->required();
  parser->add_option("B", fileB, "the reference")->required();
  const CLI::Option* byValue =
      parser->add_option("--threshold", limits.value, "a pixel differs when a value does by more than this (0)");
  const CLI::Option* byPixels = parser->add_option("--pixels", limits.pixels, "pixels that may differ (0)");
  parser->add_option("--rmse", limits.rmse, "root mean squared error allowed");
  parser->add_option("--relative-mse", limits.relativeMse, "mean of (a - b)^2 / (b^2 + 0.01) allowed");
  parser->add_option("--channels", options.channels, "compare only these")->delimiter(',');
  parser->add_option("-o,--output", output, "write |a - b| as a picture");
  parser->add_option("--gain", gain, "factor on that picture (1)");
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;

  image::Image a, b;
  for (const auto& [file, picture] : {std::pair{&fileA, &a}, std::pair{&fileB, &b}})
    if (const image::Status status = image::read(*file, *picture); !status.ok()) {
      diagnostics.error(status.code, {}, status.what, "nothing was compared");
      return kBadScene;
    }
  image::Difference difference;
  options.valueThreshold = limits.value;
  if (const image::Status status = image::compare(a, b, options, difference); !status.ok()) {
    diagnostics.error(status.code, {}, status.what, "nothing was compared");
    return kDiffers;
  }
  print(difference);
  if (!output.empty()) {
    image::Image picture;
    image::Status status = image::differencePicture(a, b, float(gain), picture);
    if (status.ok()) status = image::write(output, picture);
    if (!status.ok()) {
      diagnostics.error(status.code, {}, status.what);
      return kCannotWrite;
    }
  }
  return limits.isOver(difference, byValue->count() + byPixels->count() > 0) ? kDiffers : kComplete;
}

}  // namespace kinora::app
