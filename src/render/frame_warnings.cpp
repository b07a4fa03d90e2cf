#include "render/frame_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>

#include "film/filtered_pixels.h"
#include "render/legacy_lights.h"
#include "shade/tees.h"

namespace kinora::render {

namespace {

// Where a channel of that source is said: by its DisplayChannel, else by a Display that names it.
SourcePos posOfSource(const scene::Scene& scene, const std::string& source) {
  for (const scene::DisplayChannel& c : scene.channels)
    if (c.params.getString("source", c.name) == source) return c.pos;
  for (const scene::Display& d : scene.displays) {
    const std::string modes = "," + d.mode + ",";
    if (modes.find("," + source + ",") != std::string::npos) return d.pos;
  }
  return scene.pos;
}

// Pictures hold identifiers as floats, which tell whole numbers of up to 24 bits apart.
void warnOfIdentifiers(const FramePlan& plan, const WorldBuilder& builder, const scene::Scene& scene,
                       Diagnostics& diagnostics) {
  const auto isAsked = [&](const char* source) {
    for (int c = 0; c < plan.displays.layout.size(); ++c)
      if (plan.displays.layout[c].source == source) return true;
    return false;
  };
  for (const bool isSecond : {false, true}) {
    const std::string name = isSecond ? "id2" : "id";
    if (!isAsked(name.c_str())) continue;
    for (const shade::PlacementInfo& info : builder.world().placements) {
      const uint32_t id = isSecond ? info.objectId2 : info.objectId;
      if (double(float(id)) == double(id)) continue;
      diagnostics.warning("DISPLAY-ID", posOfSource(scene, name),
                          "the identifier " + std::to_string(int32_t(id)) + " (identifier:" + name +
                              ") has more bits than the channel \"" + name + "\" holds",
                          "pictures hold " + std::to_string(uint64_t(float(id))) + " in its place",
                          "identifiers of 0 to 16777216 are told apart");
      break;
    }
  }
}

}  // namespace

void warnOfChannels(const FramePlan& plan, const WorldBuilder& builder, const scene::Scene& scene,
                    Diagnostics& diagnostics) {
  warnOfIdentifiers(plan, builder, scene, diagnostics);
  const auto& marks = builder.world().marks;
  const auto isMarked = [&](const std::string& name) {
    return marks && std::any_of(marks->begin(), marks->end(), [&](const auto& m) { return m.channel == name; });
  };
  const auto has = [&](const std::string& channel) {
    const auto& list = plan.record.primvars;
    return std::any_of(list.begin(), list.end(), [&](const auto& p) { return p.name == channel; });
  };
  for (size_t i = 0; marks && i < marks->size(); ++i)
    if (const light::MarkEntry& m = (*marks)[i]; !has(m.channel))
      diagnostics.warning("LIGHT-CHANNEL", scene.pos,
                          "a light marks the channel '" + m.channel + "', which the frame has not",
                          "it marks nothing", "a Display must hold a channel of that name or source");
  const auto isPrimvar = [&](const std::string& name) {
    const auto& known = builder.world().primvarWidths;
    return known.contains(name) || (isReferenceSource(name) && known.contains(name.substr(2)));
  };
  for (const RecordPlan::Primvar& p : plan.record.primvars)
    if (!isMarked(p.name) && !plan.sampleFilters.uses(p.name) && !plan.displayFilters.uses(p.name) &&
        !isPrimvar(p.name) && !shade::hasTee(*builder.world().materials, p.name))
      diagnostics.warning("DISPLAY-SOURCE", posOfSource(scene, p.name),
                          "no primvar, PxrTee, PxrMatteID, light or filter of the scene gives \"" + p.name + "\"",
                          "its channel stays black",
                          "an output of a pattern or shader becomes a channel through a PxrTee: \"reference color "
                          "inputRGB\" [\"NODE:OUTPUT\"] \"string aov\" [\"" +
                              p.name + "\"], connected to the material");
}

void warnOfBounds(const Procedurals& procedurals, WorldBuilder& builder, Diagnostics& diagnostics) {
  std::map<uint32_t, Imath::Box3d> found;
  for (const Procedurals::Read& r : procedurals.lastRead())
    if (!r.isAgain) found[r.instance];
  if (found.empty()) return;
  builder.findBounds(found);
  for (const Procedurals::Read& r : procedurals.lastRead()) {
    if (r.isAgain) continue;
    const Imath::Box3d &is = found[r.instance], &said = r.bound;
    if (is.isEmpty()) continue;
    double factor = 1, most = 0, largest = 0;
    for (int k = 0; k < 3; ++k) largest = std::max({largest, said.max[k] - said.min[k], is.max[k] - is.min[k]});
    for (int k = 0; k < 3; ++k) {
      const double middle = 0.5 * (said.min[k] + said.max[k]), half = 0.5 * (said.max[k] - said.min[k]);
      const double reach = std::max(is.max[k] - middle, middle - is.min[k]);
      most = std::max(most, reach - half);
      factor = std::max(factor, reach / std::max(half, 1e-9 * largest));
    }
    double size = 0;
    for (int k = 0; k < 3; ++k) size = std::max(size, said.max[k] - said.min[k]);
    if (!(most > Procedurals::kRounded * size + 1e-6 * largest)) continue;
    diagnostics.warning(
        "RENDER-PROCEDURAL-BOUND", r.procedural->pos,
        fmt::format("'{}' holds things outside of its bound, up to {:.3g} beyond it", r.procedural->name(), most),
        "they are seen where a ray meets the bound, and elsewhere only once it was read",
        fmt::format("a bound {:.3g} times as large about its middle holds all of it", factor * 1.001));
  }
}

void warnOfMedia(const Instance& integrator, const WorldBuilder& builder, const Statistics& stats,
                 Diagnostics& diagnostics) {
  const auto* traits = static_cast<const IntegratorTraits*>(integrator.plugin()->traits);
  if (builder.world().space && !(traits && traits->scattersInMedia && traits->scattersInMedia(integrator.data())))
    diagnostics.warning("MEDIUM-INTEGRATOR", {},
                        std::string(integrator.plugin()->name) + " knows no scattering in media",
                        "they only take light away", "Integrator \"PxrPathTracer\" follows light through them");
  if (stats.mediaExcess > 1.01f) {
    char factor[32];
    std::snprintf(factor, sizeof factor, "%.3g", double(stats.mediaExcess));
    diagnostics.warning(
        "MEDIUM-BOUND", {},
        "the extinction of '" + stats.excessMedium + "' was up to " + factor + " times what it was bounded by",
        "the picture is right but noisier there",
        "maxDensity of its material says how large it gets; or smoother patterns");
  }
  if (stats.mediaOverflows)
    diagnostics.warning("MEDIUM-OVERLAP", {}, "more than 8 media overlap", "those entered last were left out there");
  if (stats.endlessTracks)
    diagnostics.warning("MEDIUM-ENDLESS", {},
                        std::to_string(stats.endlessTracks) + " rays met a medium more than 65,536 times",
                        "nothing came through there", "a smaller density, or maxDensity nearer to it");
}

void warnOfBlackness(const film::Film& f, const film::DisplayOutput& output, const scene::Scene& scene, bool hasHoles,
                     Registry& registry, Diagnostics& diagnostics) {
  const int colour = f.layout().find("Ci"), alpha = f.layout().find("a");
  if (colour < 0) return;
  const film::FilteredPixels filtered = output.filtered(f);
  const bool isUnknown = alpha < 0;
  bool isCovered = isUnknown;
  float values[16];
  for (int y = f.window().y0; y < f.window().y1; ++y)
    for (int x = f.window().x0; x < f.window().x1; ++x) {
      if (!filtered.find(colour, x, y, values)) f.resolvePixel(colour, x, y, values);
      if (values[0] != 0 || values[1] != 0 || values[2] != 0) return;
      if (isCovered) continue;
      if (!filtered.find(alpha, x, y, values)) f.resolvePixel(alpha, x, y, values);
      isCovered = values[0] != 0;
    }
  const std::string leftOut = isCovered ? lightsLeftOut(scene, registry) : "";
  diagnostics.warning(
      "RENDER-BLACK", scene.pos,
      isCovered ? std::string("every pixel is black: ") + (isUnknown ? "the camera sees nothing, or " : "") +
                      "no light reaches what " + (isUnknown ? "it" : "the camera") + " sees" +
                      (leftOut.empty() ? "" : "; these lights are not rendered: " + leftOut)
      : hasHoles ? std::string("every pixel is black and empty: the camera sees nothing but matte objects (Matte, "
                               "trace:holdout), if any")
                 : std::string("every pixel is black and empty: the camera sees nothing"),
      "the picture is written",
      isUnknown   ? "a Display with alpha, \"rgba\", would tell which"
      : isCovered ? "look at the lights, their distance and their linking"
      : hasHoles  ? "matte objects hold out what is behind them, and leave the picture empty where they are"
                  : "look at the camera's transform, the clipping planes and the messages about objects left out");
}

void warnOfSamples(const film::FilmCounters& counters, Diagnostics& diagnostics) {
  if (counters.nonFinite) {
    const film::BadSample bad = counters.bad.empty() ? film::BadSample() : counters.bad.front();
    diagnostics.warning("RENDER-NONFINITE", {},
                        std::to_string(counters.nonFinite) + " samples were not finite; the first at pixel " +
                            std::to_string(bad.x) + "," + std::to_string(bad.y) + " sample " +
                            std::to_string(bad.sampleIndex),
                        "they were left out with their weight",
                        "--only-sample " + std::to_string(bad.x) + "," + std::to_string(bad.y) + "," +
                            std::to_string(bad.sampleIndex) + " shows the path");
  }
}

void warnOfRecords(const Frame& frame, const Instance& integrator, Diagnostics& diagnostics) {
  if (frame.droppedRecords())
    diagnostics.warning("RENDER-RECORDS", {},
                        std::to_string(frame.droppedRecords()) +
                            " records that the integrator wanted to keep belong to no list that this stage writes",
                        "they were dropped",
                        "the plug-in declares its lists of records, each with the stage that writes it");
  if (!frame.learnsAsWanted())
    diagnostics.warning("RENDER-LEARNING", {},
                        std::string(integrator.plugin()->name) +
                            " wants to learn, but camera paths are not its last stage alone, or it has no function "
                            "for it",
                        "it renders with nothing learned",
                        "the plug-in has one stage of camera paths, the last, and IntegratorFunctions::learn");
}

void warnOfPaths(const Statistics& stats, Diagnostics& diagnostics) {
  if (stats.endlessRays)
    diagnostics.warning("RENDER-PASSES", {},
                        std::to_string(stats.endlessRays) +
                            " rays met more surfaces that are partly absent, clear or displaced than a ray may pass",
                        "camera and indirect rays ended there as in empty space, shadow rays as blocked",
                        "opaque cards or a coarser model where hundreds of such layers lie behind each other");
  const auto nameOf = [](const std::string& name) {
    return name.empty() ? std::string("an object without a name") : "object \"" + name + '"';
  };
  // one path of a hundred thousand slips through between facets that meet
  if (stats.lostBelow[0] * 100000 > stats.cameraHits + stats.indirectHits)
    diagnostics.warning("SUBSURFACE-OPEN", {},
                        std::to_string(stats.lostBelow[0]) +
                            " paths below a surface met nothing of its object, the first one " +
                            nameOf(stats.lostObject[0]),
                        "their light comes out where it went in, as from a diffuse surface",
                        "subsurface scattering needs closed meshes, not curves, points or sheets");
  if (stats.lostBelow[1])
    diagnostics.warning("SUBSURFACE-LONG", {},
                        std::to_string(stats.lostBelow[1]) + " paths below a surface had no end, the first in " +
                            nameOf(stats.lostObject[1]),
                        "their light comes out where it went in",
                        "a closed mesh, a longer mean free path or a darker colour");
}

}  // namespace kinora::render
