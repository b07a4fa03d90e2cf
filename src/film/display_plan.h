// From what a scene says (displays, display channels, -o) to what a film must sum and which pictures come out of it.
// Made by render/ before the first sample and by `kinora merge` from a shard; display_output.h writes the pictures.
// It opens no file and creates no driver.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"
#include "film/channel.h"
#include "film/display_values.h"
#include "image/status.h"
#include "scene/scene.h"

namespace kinora {
struct Descriptor;
}

namespace kinora::film {

// Finds a display driver by name (Registry::find of Kind::Display); null when there is none.
using DriverLookup = std::function<const Descriptor*(const std::string& name)>;

// A channel of the film inside one picture.
struct OutputChannel {
  int channel = 0;                 // index in the layout
  std::vector<std::string> names;  // in the file, one a float: "R" "G" "B", "diffuse.R" ..., "id"
  bool isColor = false;            // a colour, as opposed to alpha or data
  DisplayValues values;            // exposure, quantisation
};

// One picture file.
struct Output {
  std::string file;    // with its extension, frame number filled in
  std::string driver;  // of a plug-in ("openexr", "png"), or kImageWriter
  scene::ParameterList params;
  std::vector<OutputChannel> channels;
  bool isBeauty = false;  // holds Ci: -o means the first of these
  SourcePos pos;
};
// Formats without a driver (.tif, .jpg ...): written by image/ itself.
inline constexpr const char* kImageWriter = "image";

struct DisplayPlan {
  ChannelLayout layout;
  std::vector<Output> outputs;
  std::optional<Output> unwritten;  // of a part: what -o means where no output is beauty; no file yet
  std::vector<scene::NodePtr> displayFilters;
  std::vector<std::string> texturePath;  // of a part: where its display filters look for images
  float pixelAspect = 1;
  bool isWritable = true;  // false: two pictures would go to one file
};

struct PlanOptions {
  std::string output;      // -o: file of the primary display, format by extension; "": as the scene says
  bool splats = false;     // the integrator splats light paths: colours take them
  bool noOutputs = false;  // only the channels are wanted (tests, bench)
  bool isPart = false;     // whoever merges the parts may say -o: beauty is summed even where no display has it
};

// Problems become messages (DISPLAY-*), each with what was done instead; the plan always has channels to sum.
DisplayPlan planDisplays(const scene::Scene& scene, const PlanOptions& options, const DriverLookup& lookup,
                         Diagnostics& diagnostics);

// Whether all that a frame writes are depths for shadow maps. Renderers of shadow maps make such passes before the
// picture that looks them up; where shadows are traced nobody reads them.
bool isShadowPass(const scene::Scene& scene);

// The largest of the integers that the file holds, which its driver rounds to after encoding colours; 0: it holds
// floats.
int largestCode(const Output& output, const ChannelLayout& layout);
// Whether that takes more than a byte, by a quantize of four numbers.
bool isDeepQuantize(const std::vector<float>& quantize);

// Each "####" in a name becomes the frame number padded to as many digits (a minus counts as one).
std::string fillFrame(std::string file, int frame);

// -o for the plan of a part (kinora merge): the primary picture goes to `file`, format by its extension.
void redirectPrimary(DisplayPlan& plan, const std::string& file, Diagnostics& diagnostics);

// With -o pictures other than the primary one that name a folder of another machine go beside `file`.
void keepBeside(DisplayPlan& plan, const std::string& file, Diagnostics& diagnostics);

}  // namespace kinora::film
