#include "film/shard.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <kinora/exr_stream.h>
#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "film/json_text.h"
#include "film/shard_identity.h"
#include "image/atomic_file.h"

namespace kinora::film {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "slices point at the halves of an int64");
constexpr const char *kAttribute = "kinoraShard", *kProgress = "kinoraProgress";

std::string slotName(int slot, bool isHigh) {
  char name[32];
  std::snprintf(name, sizeof name, "s%04d.%s", slot, isHigh ? "hi" : "lo");
  return name;
}

// Slices straight into the film's memory: both halves of every slot.
Imf::FrameBuffer slicesOf(Film& film) {
  Imf::FrameBuffer buffer;
  const Window& w = film.window();
  char* base = reinterpret_cast<char*>(film.pixel(w.x0, w.y0));
  const size_t xStride = size_t(film.stride()) * sizeof(int64_t), yStride = xStride * size_t(w.width());
  // OpenEXR addresses pixel (x, y) as base + x * xStride + y * yStride
  const ptrdiff_t origin = ptrdiff_t(w.x0) * ptrdiff_t(xStride) + ptrdiff_t(w.y0) * ptrdiff_t(yStride);
  for (int s = 0; s < film.slots(); ++s)
    for (const bool isHigh : {false, true})
      buffer.insert(
          slotName(s, isHigh),
          Imf::Slice(Imf::UINT, base - origin + size_t(s) * sizeof(int64_t) + (isHigh ? 4 : 0), xStride, yStride));
  return buffer;
}

json toJson(const Film& film, const ShardInfo& info) {
  json channels = json::array();
  for (const Channel& c : film.layout().channels())
    channels.push_back({{"name", jsonOfText(c.name)},
                        {"type", int(c.type)},
                        {"width", c.width},
                        {"reducer", int(c.reducer)},
                        {"half", int(c.half)},
                        {"stepLog2", c.stepLog2},
                        {"limit", c.limit},
                        {"isData", c.isData},
                        {"splats", c.splats},
                        {"source", jsonOfText(c.source)},
                        {"statistic", int(c.statistic)},
                        {"filter", jsonOfText(c.filter.name)},
                        {"filterWidth", {c.filter.xWidth, c.filter.yWidth}},
                        {"remap", c.remap}});
  json ranges = json::array();
  for (const SampleRange& r : info.ranges) ranges.push_back({r.begin, r.end});
  const FilmCounters counters = film.counters();
  json bad = json::array();
  for (const BadSample& b : counters.bad)
    bad.push_back({{"x", b.x},
                   {"y", b.y},
                   {"sample", b.sampleIndex},
                   {"channel", b.channel},
                   {"valueBits", std::bit_cast<uint32_t>(b.value)},
                   {"splat", b.isSplat}});
  json lobes = json::array();  // of the frame's filter, then of those of channels
  for (int f = -1; f < int(film.layout().filters().size()); ++f) lobes.push_back(film.layout().negative(f));
  const Window& w = film.window();
  return {{"version", ShardInfo::kVersion},
          {"sceneHash", info.sceneHash},
          {"inventory", inventoryToJson(info.inventory)},
          {"lateFiles", filesToJson(info.lateFiles)},
          {"seed", info.seed},
          {"frame", info.frame},
          {"pixelFilter", jsonOfText(info.pixelFilter)},
          {"negativeLobes", lobes},
          {"samples", ranges},
          {"renderSeconds", info.renderSeconds},
          {"kinoraVersion", info.kinoraVersion},
          {"outputs", info.outputs},
          {"resolution", {film.width(), film.height()}},
          {"window", {w.x0, w.y0, w.x1, w.y1}},
          {"channels", channels},
          {"saturated", counters.saturated},
          {"nonFinite", counters.nonFinite},
          {"negative", counters.negative},
          {"bad", bad},
          {"splatPasses", film.splatPasses()}};
}

Status broken(const std::string& path, const std::string& why) {
  return Status::fail("FILM-SHARD-READ", "\"" + path + "\" is not a usable shard: " + why);
}

template <typename Enum>
Enum enumFrom(const json& j, Enum last) {
  const int v = j.get<int>();
  if (v < 0 || v > int(last)) throw std::runtime_error("a channel's description is out of range");
  return Enum(v);
}

Channel channelFrom(const json& j) {
  Channel c;
  c.name = textOfJson(j.at("name"));
  c.type = enumFrom(j.at("type"), ChannelType::Int);
  c.width = j.at("width").get<int>();
  c.reducer = enumFrom(j.at("reducer"), Reducer::ZMax);
  c.half = enumFrom(j.at("half"), Half::Odd);
  c.stepLog2 = j.at("stepLog2").get<int>();
  c.limit = j.at("limit").get<float>();
  c.isData = j.at("isData").get<bool>();
  c.splats = j.at("splats").get<bool>();
  c.source = textOfJson(j.at("source"));
  c.statistic = enumFrom(j.at("statistic"), Statistic::MeanVariance);
  c.filter.name = textOfJson(j.at("filter"));
  const auto widths = j.at("filterWidth").get<std::array<float, 2>>();
  c.filter.xWidth = widths[0];
  c.filter.yWidth = widths[1];
  c.remap = j.at("remap").get<std::array<float, 3>>();
  return c;
}

Status checkRanges(const std::vector<SampleRange>& ranges, const std::string& path) {
  uint32_t end = 0;
  for (const SampleRange& r : ranges) {
    if (r.begin >= r.end || r.begin < end) return broken(path, "its sample ranges are empty or out of order");
    end = r.end;
  }
  return ranges.empty() ? broken(path, "it has no sample range") : Status{};
}

// Everything but the pixels. Throws on JSON of the wrong shape.
Status readDescription(const std::string& path, const json& j, Shard& out, FilmCounters& counters,
                       uint64_t maxBytes) {
  const int version = j.at("version").get<int>();
  if (version != ShardInfo::kVersion)
    return Status::fail("FILM-SHARD-VERSION", "\"" + path + "\" is a shard of version " + std::to_string(version) +
                                                  "; this program reads version " +
                                                  std::to_string(ShardInfo::kVersion));
  ShardInfo& info = out.info;
  info.sceneHash = j.at("sceneHash").get<std::string>();
  info.inventory = inventoryFromJson(j.at("inventory"));
  info.lateFiles = filesFromJson(j.at("lateFiles"));
  info.seed = j.at("seed").get<uint64_t>();
  info.frame = j.at("frame").get<int>();
  info.pixelFilter = textOfJson(j.at("pixelFilter"));
  info.renderSeconds = j.at("renderSeconds").get<double>();
  info.kinoraVersion = j.at("kinoraVersion").get<std::string>();
  info.outputs = j.at("outputs").get<std::string>();
  info.ranges.clear();
  for (const json& r : j.at("samples")) info.ranges.push_back({r.at(0).get<uint32_t>(), r.at(1).get<uint32_t>()});
  if (Status s = checkRanges(info.ranges, path); !s.ok()) return s;
  const json& w = j.at("window");
  const Window window{w.at(0).get<int>(), w.at(1).get<int>(), w.at(2).get<int>(), w.at(3).get<int>()};
  ChannelLayout layout;
  for (const json& c : j.at("channels")) {
    std::string error;
    if (layout.add(channelFrom(c), &error) < 0) return broken(path, error);
  }
  const auto lobes = j.at("negativeLobes").get<std::vector<double>>();
  if (lobes.size() != layout.filters().size() + 1) return broken(path, "a filter is not described");
  for (size_t f = 0; f < lobes.size(); ++f) {
    if (!(lobes[f] >= 0 && lobes[f] < 1e6)) return broken(path, "a filter's negative lobes are out of range");
    layout.setNegative(int(f) - 1, lobes[f]);
  }
  Status status;
  out.film = Film::create(j.at("resolution").at(0).get<int>(), j.at("resolution").at(1).get<int>(), window, layout,
                          status, maxBytes);
  if (!status.ok()) return broken(path, status.what);
  counters.saturated = j.at("saturated").get<std::vector<uint64_t>>();
  counters.nonFinite = j.at("nonFinite").get<uint64_t>();
  counters.negative = j.at("negative").get<uint64_t>();
  for (const json& b : j.at("bad")) {
    if (counters.bad.size() == Film::kKeptBad) break;
    counters.bad.push_back({b.at("y").get<int>(), b.at("x").get<int>(), b.at("sample").get<uint32_t>(),
                            b.at("channel").get<int>(), std::bit_cast<float>(b.at("valueBits").get<uint32_t>()),
                            b.at("splat").get<bool>()});
  }
  return {};
}

}  // namespace

Status writeShard(const std::string& path, const Film& film, const ShardInfo& info) {
  image::AtomicFile file(path);
  if (Status s = file.probe(); !s.ok()) return s;
  int error = 0;
  try {
    const Window& w = film.window();
    Imf::Header header(Imath::Box2i({0, 0}, {film.width() - 1, film.height() - 1}),
                       Imath::Box2i({w.x0, w.y0}, {w.x1 - 1, w.y1 - 1}), 1, {0, 0}, 1, Imf::INCREASING_Y,
                       Imf::ZIP_COMPRESSION);
    for (int s = 0; s < film.slots(); ++s)
      for (const bool isHigh : {false, true}) header.channels().insert(slotName(s, isHigh), Imf::Channel(Imf::UINT));
    header.insert(kAttribute, Imf::StringAttribute(toJson(film, info).dump()));
    if (!info.progress.empty()) header.insert(kProgress, Imf::StringAttribute(info.progress));
    ExrStream stream(file.path());
    try {
      Imf::OutputFile out(stream, header);
      // OpenEXR takes slices for writing as non-const; it only reads them
      out.setFrameBuffer(slicesOf(const_cast<Film&>(film)));
      out.writePixels(w.height());
    } catch (...) {
      if (!(error = stream.finish())) throw;
    }
    if (!error) error = stream.finish();
  } catch (const std::exception& e) {
    return Status::fail("FILM-SHARD-WRITE", "cannot write shard \"" + path + "\": " + e.what());
  }
  if (error) return Status::fail("FILM-SHARD-WRITE", "cannot write shard \"" + path + "\": " + std::strerror(error));
  return file.commit();
}

bool isShard(const std::string& path) {
  try {
    Imf::InputFile in(path.c_str());
    return in.header().findTypedAttribute<Imf::StringAttribute>(kAttribute) != nullptr;
  } catch (const std::exception&) {
    return false;
  }
}

Status readShard(const std::string& path, Shard& out, uint64_t maxBytes) {
  out = {};
  struct stat fileInfo;
  if (stat(path.c_str(), &fileInfo) != 0) return broken(path, std::strerror(errno));
  if (!S_ISREG(fileInfo.st_mode)) return broken(path, "it is not a file");
  try {
    // OpenEXR sizes its table of lines by the header before any check of ours
    Imf::Header::setMaxImageSize(Film::kMaxResolution, Film::kMaxResolution);
    Imf::InputFile in(path.c_str());
    const auto* attribute = in.header().findTypedAttribute<Imf::StringAttribute>(kAttribute);
    if (!attribute) return broken(path, "it is a picture, not a shard (rendered without --samples?)");
    const json j = json::parse(attribute->value());
    // a zip block of zeros shrinks to no less than 1/1032: a small file cannot ask for much memory
    maxBytes = std::min(maxBytes, (uint64_t(1) << 28) + uint64_t(fileInfo.st_size) * 2048);
    FilmCounters counters;
    if (Status s = readDescription(path, j, out, counters, maxBytes); !s.ok()) {
      out = {};
      return s;
    }
    if (const auto* progress = in.header().findTypedAttribute<Imf::StringAttribute>(kProgress))
      out.info.progress = progress->value();
    Film& film = *out.film;
    const Window& w = film.window();
    const Imath::Box2i box = in.header().dataWindow();
    Status status;
    if (box.min.x != w.x0 || box.min.y != w.y0 || box.max.x != w.x1 - 1 || box.max.y != w.y1 - 1)
      status = broken(path, "its data window contradicts its description");
    int count = 0;
    for (auto it = in.header().channels().begin(); it != in.header().channels().end(); ++it, ++count)
      if (it.channel().type != Imf::UINT || it.channel().xSampling != 1 || it.channel().ySampling != 1)
        status = broken(path, "its channels are not 32-bit integers");
    for (int s = 0; status.ok() && s < film.slots(); ++s)
      if (!in.header().channels().findChannel(slotName(s, false)) ||
          !in.header().channels().findChannel(slotName(s, true)))
        status = broken(path, "integers are missing");
    if (status.ok() && count != 2 * film.slots()) status = broken(path, "it has channels that its description lacks");
    if (status.ok()) {
      in.setFrameBuffer(slicesOf(film));
      in.readPixels(box.min.y, box.max.y);
      film.addCounters(counters, j.at("splatPasses").get<int64_t>());
    }
    if (!status.ok()) out = {};
    return status;
  } catch (const std::exception& e) {
    out = {};
    return broken(path, e.what());
  }
}

Status isOfOneFrame(const ShardInfo& before, const ShardInfo& part) {
  if (part.seed != before.seed)
    return Status::fail("FILM-SHARD-SEED", "the parts have different seeds (" + std::to_string(before.seed) +
                                               " and " + std::to_string(part.seed) + ")");
  if (part.frame != before.frame)
    return Status::fail("FILM-SHARD-FRAME", "the parts are of different frames (" + std::to_string(before.frame) +
                                                " and " + std::to_string(part.frame) + ")");
  if (const std::string difference = sceneDifference(before, part); !difference.empty())
    return Status::fail("FILM-SHARD-SCENE", "it is of another scene than the parts before it: " + difference);
  return {};
}

Status addShard(Shard& sum, const Shard& part) {
  if (Status s = isOfOneFrame(sum.info, part.info); !s.ok()) return s;
  for (const SampleRange& a : sum.info.ranges)
    for (const SampleRange& b : part.info.ranges)
      if (a.begin < b.end && b.begin < a.end)
        return Status::fail("FILM-SHARD-OVERLAP", "samples " + std::to_string(std::max(a.begin, b.begin)) + ":" +
                                                      std::to_string(std::min(a.end, b.end)) +
                                                      " are in two of the parts");
  if (Status s = sum.film->merge(*part.film); !s.ok()) return s;
  sum.info.ranges.insert(sum.info.ranges.end(), part.info.ranges.begin(), part.info.ranges.end());
  std::sort(sum.info.ranges.begin(), sum.info.ranges.end(),
            [](const SampleRange& a, const SampleRange& b) { return a.begin < b.begin; });
  std::vector<SampleRange> joined;
  for (const SampleRange& r : sum.info.ranges) {
    if (!joined.empty() && joined.back().end == r.begin)
      joined.back().end = r.end;
    else
      joined.push_back(r);
  }
  sum.info.ranges = std::move(joined);
  sum.info.renderSeconds += part.info.renderSeconds;
  sum.info.progress.clear();
  for (const FileContents::Entry& f : part.info.lateFiles)
    if (std::find(sum.info.lateFiles.begin(), sum.info.lateFiles.end(), f) == sum.info.lateFiles.end())
      sum.info.lateFiles.push_back(f);
  return {};
}

Status mergeShards(const std::vector<std::string>& paths, Shard& out, std::vector<std::string>& warnings,
                   uint64_t maxBytes) {
  out = {};
  if (paths.empty()) return Status::fail("FILM-SHARD-NONE", "no shards are given");
  for (const std::string& path : paths) {
    Shard part;
    Status s = readShard(path, part, maxBytes);
    if (s.ok() && out.film) {
      s = addShard(out, part);
      if (!s.ok()) s.what = "\"" + path + "\": " + s.what;
    } else if (s.ok()) {
      out = std::move(part);
    }
    if (!s.ok()) {
      out = {};
      return s;
    }
  }
  uint32_t end = 0;
  for (const SampleRange& r : out.info.ranges) {
    if (r.begin != end)
      warnings.push_back("samples " + std::to_string(end) + ":" + std::to_string(r.begin) +
                         " are in none of the parts");
    end = r.end;
  }
  return {};
}

}  // namespace kinora::film
