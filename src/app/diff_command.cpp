// `kinora diff A B`; the comparison is film/tools.h's.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "film/tools.h"

namespace kinora::app {

int runDiff(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser =
      makeParser("diff",
                 "Compares two images. Exit code 1 when a limit is exceeded; without a limit, when any "
                 "value differs by more than the threshold.");
  std::string a, b, picture;
  film::DiffLimits limits;
  std::vector<float> part;
  float gain = 1;
  parser->add_option("A", a, "an image")->required();
  parser->add_option("B", b, "the reference")->required();
  parser->add_option("--threshold", limits.valueThreshold, "values this close are equal (0)")->type_name("V");
  parser->add_option("--max", limits.maximum, "limit on the largest difference of a value")->type_name("V");
  parser->add_option("--rmse", limits.rmse, "limit on the root mean squared error")->type_name("V");
  parser->add_option("--relative-mse", limits.relativeMse, "limit on the mean relative squared error")
      ->type_name("V");
  parser->add_option("--pixels", limits.differingPixels, "limit on the share of differing pixels, 0..1")
      ->type_name("SHARE");
  takeOneAtATime(
      parser->add_option("--channels", limits.channels, "compare only these")->type_name("A,B")->delimiter(','));
  addCrop(*parser, part, "compare only this part of the pictures, in 0..1 as CropWindow");
  parser->add_option("-o,--output", picture, "write |A - B| as a picture")->type_name("FILE");
  parser->add_option("--gain", gain, "factor on that picture (1)")->type_name("G");
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;
  const auto isAtLeast0 = [](std::optional<double> x) { return !x || *x >= 0; };  // no number is not, either
  for (const auto& [name, value] : {std::pair{"--threshold", std::optional(limits.valueThreshold)},
                                    {"--max", limits.maximum},
                                    {"--rmse", limits.rmse},
                                    {"--relative-mse", limits.relativeMse},
                                    {"--pixels", limits.differingPixels}})
    if (!isAtLeast0(value)) return badCommandLine(diagnostics, std::string(name) + " takes a number of 0 or more");
  if (!part.empty())
    if (const auto wrong = readCrop(part, limits.part)) return badCommandLine(diagnostics, *wrong);
  if (isOverInput(diagnostics, picture, {a, b})) return kBadCommandLine;
  const film::ToolResult result = film::diffImages(a, b, limits, picture, gain, diagnostics);
  fmt::print("{}", result.text);
  return result.exitCode;
}

}  // namespace kinora::app
