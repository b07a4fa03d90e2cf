#include "film/tools.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "film/display_output.h"
#include "film/shard.h"
#include "image/atomic_file.h"
#include "image/compare.h"
#include "image/read_write.h"

namespace kinora::film {
namespace {

ToolResult failed(const image::Status& status, int exitCode, Diagnostics& diagnostics) {
  diagnostics.error(status.code, {}, status.what);
  return {exitCode, {}};
}

const char* nameOf(image::StoredType t) {
  static const char* const kNames[] = {"uint8", "uint16", "half", "float"};
  return kNames[int(t)];
}

std::string textOf(const image::MetaValue& value) {
  if (const int* i = std::get_if<int>(&value)) return std::to_string(*i);
  if (const float* f = std::get_if<float>(&value)) return fmt::format("{}", *f);
  if (const std::string* s = std::get_if<std::string>(&value)) {
    std::string line = s->size() > 200 ? s->substr(0, 200) + "..." : *s;
    for (char& c : line)
      if (static_cast<unsigned char>(c) < 32) c = ' ';
    return line;
  }
  std::string s;
  for (const float v : std::get<image::Matrix44>(value)) s += (s.empty() ? "" : " ") + fmt::format("{}", v);
  return s;
}

std::string windowText(const image::Window& w) { return fmt::format("{} {} to {} {}", w.x0, w.y0, w.x1, w.y1); }

std::string shownRanges(const std::vector<SampleRange>& ranges) {
  std::string s;
  for (const SampleRange& r : ranges) s += fmt::format("{}{}:{}", s.empty() ? "" : " ", r.begin, r.end);
  return s;
}

ToolResult shardInfo(const std::string& path, Diagnostics& diagnostics) {
  Shard shard;
  if (const image::Status s = readShard(path, shard); !s.ok()) return failed(s, kToolUnreadable, diagnostics);
  const Film& film = *shard.film;
  const FilmCounters counters = film.counters();
  ToolResult result;
  result.text = fmt::format(
      "{}: shard of a frame (kinora merge makes the picture)\n  resolution: {} x {}\n  data window: {}\n  samples: "
      "{}\n"
      "  seed: {}\n  frame: {}\n  scene hash: {}\n  pixel filter: {}\n  render seconds: {:.2f}\n  Kinora: {}\n",
      path, film.width(), film.height(), windowText(film.window()), shownRanges(shard.info.ranges), shard.info.seed,
      shard.info.frame, shard.info.sceneHash, shard.info.pixelFilter, shard.info.renderSeconds,
      shard.info.kinoraVersion);
  for (int c = 0; c < film.layout().size(); ++c)
    result.text +=
        fmt::format("  channel {}: {} float{}, {} saturated\n", film.layout()[c].name, film.layout()[c].width,
                    film.layout()[c].width == 1 ? "" : "s", counters.saturated[size_t(c)]);
  result.text += fmt::format("  dropped samples (not finite): {}\n  negative samples (kept): {}\n",
                             counters.nonFinite, counters.negative);
  return result;
}

// A picture that would take the place of a part: hours of samples, lost.
bool isOverPart(const std::vector<std::string>& parts, const std::string& file, Diagnostics& diagnostics) {
  for (const std::string& part : parts) {
    if (!image::isSameFile(part, file)) continue;
    diagnostics.error("FILM-MERGE-OVERWRITE", {}, "\"" + file + "\" would be written over the part \"" + part + "\"",
                      "nothing is written", "name another file with -o");
    return true;
  }
  return false;
}

}  // namespace

ToolResult diffImages(const std::string& a, const std::string& b, const DiffLimits& limits,
                      const std::string& picture, float gain, Diagnostics& diagnostics) {
  image::Image first, second;
  if (const image::Status s = image::read(a, first); !s.ok()) return failed(s, kToolUnreadable, diagnostics);
  if (const image::Status s = image::read(b, second); !s.ok()) return failed(s, kToolUnreadable, diagnostics);
  image::Difference d;
  if (const image::Status s =
          image::compare(first, second, {limits.valueThreshold, 1e-2, limits.channels, limits.part}, d);
      !s.ok()) {
    // pictures that cannot be compared are different; the message says how
    diagnostics.error(s.code, {}, s.what);
    return {kToolDiffers, {}};
  }
  const double share = d.pixels ? double(d.differingPixels) / double(d.pixels) : 0;
  std::vector<std::string> over;
  const auto check = [&](const std::optional<double>& limit, double value, const char* name) {
    if (limit && !(value <= *limit)) over.push_back(fmt::format("{} {:.6g} is above {:.6g}", name, value, *limit));
  };
  check(limits.rmse, d.rmse, "RMSE");
  check(limits.relativeMse, d.relativeMse, "relative MSE");
  check(limits.maximum, d.oneSidedNan ? INFINITY : d.maximum, "maximum");
  check(limits.differingPixels, share, "share of differing pixels");
  const bool isAnyLimit = limits.rmse || limits.relativeMse || limits.maximum || limits.differingPixels;
  if (!isAnyLimit && d.differingValues) over.push_back("the pictures differ");
  if (!isAnyLimit && (!d.onlyA.empty() || !d.onlyB.empty()) && limits.channels.empty())
    over.push_back("their channels differ");
  // a mean over finite values says nothing about what is NaN or infinite in one picture only
  if (isAnyLimit && d.oneSidedNan && !limits.maximum && !limits.differingPixels)
    over.push_back(fmt::format("{} values are NaN in one picture only", d.oneSidedNan));
  if (isAnyLimit && std::isinf(d.maximum) && !limits.maximum && !limits.differingPixels)
    over.push_back("some values are infinite in one picture only");

  ToolResult result;
  result.text = fmt::format(
      "RMSE {:.6g}\nrelative MSE {:.6g}\nmaximum {:.6g}{}\ndiffering pixels {} of {} ({:.4f} %)\ndiffering values {} "
      "of {}\n"
      "means {:.6g} {:.6g}\n",
      d.rmse, d.relativeMse, d.maximum,
      d.maximum > 0 ? fmt::format(" at {} {} in {}", d.maximumX, d.maximumY, d.maximumChannel) : "",
      d.differingPixels, d.pixels, 100 * share, d.differingValues, d.values, d.meanA, d.meanB);
  if (d.nanA || d.nanB) result.text += fmt::format("NaN values {} {}\n", d.nanA, d.nanB);
  for (const std::string& name : d.onlyA) result.text += fmt::format("only in the first: channel {}\n", name);
  for (const std::string& name : d.onlyB) result.text += fmt::format("only in the second: channel {}\n", name);
  if (d.isBitEqual) result.text += "identical in every bit\n";
  for (const std::string& line : over) result.text += "over the threshold: " + line + "\n";
  result.exitCode = over.empty() ? kToolOk : kToolDiffers;
  if (!picture.empty()) {
    image::Image difference;
    image::Status s = image::differencePicture(first, second, gain, difference);
    if (s.ok()) s = image::write(picture, difference);
    if (!s.ok()) return failed(s, kToolUnwritable, diagnostics);
    result.text += "difference picture " + picture + "\n";
  }
  return result;
}

ToolResult mergeParts(const std::vector<std::string>& parts, const std::string& output, bool keepShard,
                      const DriverLookup& lookup, const StageMaker& stages, Diagnostics& diagnostics) {
  if (!output.empty() && isOverPart(parts, output, diagnostics)) return {kToolBadCommand, {}};
  Shard merged;
  std::vector<std::string> warnings;
  if (const image::Status s = mergeShards(parts, merged, warnings); !s.ok())
    return failed(s, kToolUnreadable, diagnostics);
  for (const std::string& w : warnings)
    diagnostics.warning("FILM-SHARD-GAP", {}, w, "the picture is made without them",
                        "render and add the missing part");
  const Film& film = *merged.film;
  ToolResult result;
  result.text = fmt::format("{} part{}, samples {}\n", parts.size(), parts.size() == 1 ? "" : "s",
                            shownRanges(merged.info.ranges));
  if (keepShard) {
    if (const image::Status s = writeShard(output, film, merged.info); !s.ok())
      return failed(s, kToolUnwritable, diagnostics);
    result.text += output + "\n";
    return result;
  }
  DisplayPlan plan;
  FrameMetadata frame;
  if (const image::Status s = outputsFromJson(merged.info.outputs, film.layout(), plan, frame); !s.ok())
    return failed(s, kToolUnreadable, diagnostics);
  if (plan.outputs.empty() && (output.empty() || !plan.unwritten)) {
    diagnostics.error("FILM-SHARD-OUTPUTS", {}, "the parts name no picture", "nothing is written",
                      "-o FILE makes one of the colour and alpha");
    return {kToolUnreadable, {}};
  }
  if (!output.empty()) {
    redirectPrimary(plan, output, diagnostics);
    keepBeside(plan, output, diagnostics);
  }
  if (!plan.isWritable) return {kToolBadCommand, {}};
  for (const Output& o : plan.outputs)
    if (isOverPart(parts, o.file, diagnostics)) return {kToolBadCommand, {}};
  frame.frame = merged.info.frame;
  frame.seed = merged.info.seed;
  frame.samples = merged.info.ranges;
  frame.sceneHash = merged.info.sceneHash;
  frame.pixelFilter = merged.info.pixelFilter;
  frame.renderSeconds = merged.info.renderSeconds;
  frame.kinoraVersion = merged.info.kinoraVersion;
  frame.isComplete = warnings.empty();
  for (const SampleRange& r : merged.info.ranges) frame.samplesPerPixel += r.end - r.begin;
  const DisplayOutput::PixelStage stage =
      stages && !plan.displayFilters.empty() ? stages(plan, film) : DisplayOutput::PixelStage();
  DisplayOutput out(std::move(plan), lookup, diagnostics);
  out.setPixelStage(stage);
  if (!out.write(film, frame)) result.exitCode = kToolUnwritable;
  for (const std::string& file : out.written()) result.text += file + "\n";
  return result;
}

ToolResult imageInfo(const std::string& path, Diagnostics& diagnostics) {
  if (isShard(path)) return shardInfo(path, diagnostics);
  image::Image picture;
  if (const image::Status s = image::read(path, picture); !s.ok()) return failed(s, kToolUnreadable, diagnostics);
  ToolResult result;
  const auto format = picture.metadata.find("format");
  result.text = fmt::format("{}: {} picture, {} x {}, {} channels\n", path,
                            format == picture.metadata.end() ? "" : textOf(format->second), picture.width(),
                            picture.height(), picture.channelCount());
  if (!(picture.data == picture.display))
    result.text += fmt::format("  data window: {}\n  display window: {}\n", windowText(picture.data),
                               windowText(picture.display));
  const size_t n = picture.channels.size();
  for (size_t c = 0; c < n; ++c) {
    float low = INFINITY, high = -INFINITY;
    double sum = 0;
    uint64_t finite = 0, other = 0;
    for (size_t i = c; i < picture.pixels.size(); i += n) {
      const float v = picture.pixels[i];
      if (!std::isfinite(v)) {
        ++other;
        continue;
      }
      low = std::min(low, v);
      high = std::max(high, v);
      sum += v;
      ++finite;
    }
    result.text += fmt::format("  channel {} ({}): ", picture.channels[c].name, nameOf(picture.channels[c].type));
    result.text += finite ? fmt::format("{:.6g} to {:.6g}, mean {:.6g}", low, high, sum / double(finite))
                          : std::string("no finite value");
    if (other) result.text += fmt::format(", {} not finite", other);
    result.text += "\n";
  }
  for (const auto& [key, value] : picture.metadata)
    if (key != "format") result.text += "  " + key + ": " + textOf(value) + "\n";
  return result;
}

}  // namespace kinora::film
