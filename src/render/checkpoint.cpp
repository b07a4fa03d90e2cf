#include "render/checkpoint.h"

#include <zlib.h>

#include <charconv>
#include <cstring>
#include <filesystem>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/quantity.h"

namespace kinora::render {

namespace {

constexpr uint32_t kCheckpointVersion = 1;

// What the classes of adaptive.h show of themselves, value by value.
class StateWriter {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(uint64_t(values.size()));
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  std::string bytes;
};

// Takes vectors of the sizes alone that are there: those of the frame's window.
class StateReader {
 public:
  explicit StateReader(const std::string& bytes) : bytes_(bytes) {}
  template <class T>
  void operator()(T& value) {
    take(&value, sizeof value);
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    uint64_t n = 0;
    (*this)(n);
    isGood_ = isGood_ && n == values.size();
    if (isGood_) take(values.data(), values.size() * sizeof(T));
  }
  bool isAtEnd() const { return isGood_ && at_ == bytes_.size(); }

 private:
  void take(void* to, size_t n) {
    isGood_ = isGood_ && n <= bytes_.size() - at_;
    if (!isGood_ || n == 0) return;  // an empty list is nowhere
    std::memcpy(to, bytes_.data() + at_, n);
    at_ += n;
  }
  const std::string& bytes_;
  size_t at_ = 0;
  bool isGood_ = true;
};

// version, size, packed: sums of blocks are mostly small numbers
std::string packed(const std::string& bytes) {
  uLongf size = compressBound(uLong(bytes.size()));
  std::string out(16 + size, '\0');
  const uint64_t plain = bytes.size();
  std::memcpy(out.data(), &kCheckpointVersion, sizeof kCheckpointVersion);
  std::memcpy(out.data() + 8, &plain, sizeof plain);
  compress2(reinterpret_cast<Bytef*>(out.data() + 16), &size, reinterpret_cast<const Bytef*>(bytes.data()),
            uLong(bytes.size()), 1);
  out.resize(16 + size);
  return out;
}

// `most`: bytes that can be meant.
std::optional<std::string> unpacked(const std::string& from, uint64_t most) {
  uint32_t version = 0;
  uint64_t plain = 0;
  if (from.size() < 16) return std::nullopt;
  std::memcpy(&version, from.data(), sizeof version);
  std::memcpy(&plain, from.data() + 8, sizeof plain);
  if (version != kCheckpointVersion || plain > most) return std::nullopt;
  std::string out(plain, '\0');
  uLongf size = uLongf(plain);
  if (uncompress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(from.data() + 16),
                 uLong(from.size() - 16)) != Z_OK ||
      size != plain)
    return std::nullopt;
  return out;
}

// What the file says of the frame's samples; a frame that goes on from it has the same but for the last two.
struct Standing {
  int first = 0, stride = 1;
  Adaptivity adaptivity;
  int most = 0;  // with adaptive sampling: samples a pixel
  int samplesDone = 0;
  uint64_t samplesTaken = 0;
};
Standing standingOf(const Sampled& s) {
  return {s.counts.first, s.counts.stride, s.counts.adaptivity, s.noise ? s.counts.count() : 0,
          s.samplesDone,  s.samplesTaken};
}

template <class Archive, class OneStanding, class Active, class Noise, class Decided>
void exchange(Archive& archive, OneStanding& s, Active& active, Noise* noise, Decided& decided) {
  archive(s.first);
  archive(s.stride);
  archive(s.adaptivity);
  archive(s.most);
  archive(s.samplesDone);
  archive(s.samplesTaken);
  if (!noise) return;
  ActivePixels::exchange(active, archive);
  NoiseEstimate::exchange(*noise, archive);
  Convergence::exchange(decided, archive);
}

std::string plainProgressOf(const Sampled& s) {
  StateWriter writer;
  const Standing standing = standingOf(s);
  exchange(writer, standing, std::as_const(s.active), static_cast<const NoiseEstimate*>(s.noise),
           std::as_const(s.convergence));
  return std::move(writer.bytes);
}

// What a checkpoint says of a frame, where that is this one, with these settings.
struct KeptState {
  Standing standing;
  ActivePixels active;
  std::optional<NoiseEstimate> noise;
  Convergence convergence;
};
std::optional<KeptState> readProgress(const std::string& bytes, const Sampled& s) {
  // as many bytes as this frame would write
  const std::optional<std::string> plain = unpacked(bytes, plainProgressOf(s).size());
  if (!plain) return std::nullopt;
  KeptState p{{}, s.active, std::nullopt, s.convergence};
  if (s.noise) p.noise = *s.noise;
  StateReader reader(*plain);
  exchange(reader, p.standing, p.active, p.noise ? &*p.noise : nullptr, p.convergence);
  const Standing &there = p.standing, own = standingOf(s);
  if (!reader.isAtEnd() || there.first != own.first || there.stride != own.stride ||
      there.adaptivity != own.adaptivity || there.most != own.most || there.samplesDone <= 0 ||
      there.samplesDone > s.counts.count())
    return std::nullopt;
  return p;
}

}  // namespace

std::optional<CheckpointTime> parseCheckpointTime(std::string_view text) {
  const bool isPasses = text.ends_with('i'), isNegative = text.starts_with('-');
  if (!isPasses && !isNegative) {
    const auto seconds = parseTime(text);
    return seconds ? std::optional(CheckpointTime{*seconds, 0}) : std::nullopt;
  }
  if (isPasses) text.remove_suffix(1);
  if (isNegative) text.remove_prefix(1);
  int passes = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), passes);
  if (error != std::errc() || end != text.data() + text.size() || passes < 0) return std::nullopt;
  return CheckpointTime{0, passes};
}

Checkpointing checkpointingOf(const scene::Scene& scene, const Checkpointing& commandLine, Diagnostics& diagnostics) {
  Checkpointing out = commandLine;
  if (out.file.empty()) return out;
  const auto timeOf = [&](const char* name, CheckpointTime& to) {
    const std::string text = scene.options.getString(std::string("checkpoint:") + name, "");
    if (text.empty()) return;
    if (const auto time = parseCheckpointTime(text))
      to = *time;
    else
      diagnostics.warning("RENDER-CHECKPOINT", scene.pos,
                          "Option \"checkpoint\" \"" + std::string(name) + "\" is \"" + text + "\", which is no time",
                          "it is ignored", "\"10m\", \"0.5h\", \"30s\", or passes as \"16i\"");
  };
  if (!out.every.isSet() && !out.exitAt.isSet()) {
    timeOf("interval", out.every);
    timeOf("exitat", out.exitAt);
  }
  out.keepsFile = scene.options.getInt("checkpoint:keepfiles", 0) != 0;
  return out;
}

bool Checkpoints::isThere() const {
  std::error_code unknown;
  return wanted_.recovers && std::filesystem::exists(wanted_.file, unknown);
}

void Checkpoints::recover(const Sampled& s, const film::ShardInfo& own, Diagnostics& diagnostics) {
  film::Shard before;
  film::Status status = film::readShard(wanted_.file, before, s.film.bytes() + (uint64_t(1) << 20));
  if (status.ok()) status = film::isOfOneFrame(own, before.info);
  std::optional<KeptState> kept;
  if (status.ok() && !(kept = readProgress(before.info.progress, s)))
    status = film::Status::fail("RENDER-RECOVER", "it has other samples than are asked for");
  if (status.ok()) status = s.film.merge(*before.film);
  if (!status.ok()) {
    diagnostics.warning("RENDER-RECOVER", {}, "\"" + wanted_.file + "\": " + status.what,
                        "the frame is rendered from its first sample",
                        "--recover goes on with the scene and settings that the checkpoint is of");
    return;
  }
  s.samplesDone = kept->standing.samplesDone;
  s.samplesTaken = kept->standing.samplesTaken;
  if (s.noise) {
    s.active = std::move(kept->active);
    *s.noise = std::move(*kept->noise);
    s.convergence = std::move(kept->convergence);
  }
  recovered_ = {s.samplesDone, s.samplesTaken, before.info.renderSeconds, std::move(before.info.lateFiles)};
  diagnostics.info("RENDER-RECOVERED", {},
                   "\"" + wanted_.file + "\" has " + std::to_string(s.samplesDone) +
                       " samples a pixel, from where the frame goes on");
}

void Checkpoints::passBegins(const Sampled& s) {
  ++passes_;
  const image::Window& w = s.film.window();
  const int64_t* sums = s.film.pixel(w.x0, w.y0);
  sums_.assign(sums, sums + s.film.bytes() / sizeof(int64_t));
  if (s.noise) noise_ = *s.noise;
}

void Checkpoints::fallBack(const Sampled& s) const {
  if (sums_.empty()) return;
  const image::Window& w = s.film.window();
  std::memcpy(s.film.pixel(w.x0, w.y0), sums_.data(), sums_.size() * sizeof(int64_t));
  if (s.noise && noise_) *s.noise = *noise_;
}

bool Checkpoints::isDue(double seconds, bool isAsked) const {
  return wanted_.isOn() &&
         (isAsked || isOver(seconds) || wanted_.every.isOver(seconds - secondsThen_, passes_ - passesThen_));
}

void Checkpoints::write(const Sampled& s, film::ShardInfo info, double seconds, Diagnostics& diagnostics) {
  info.progress = packed(plainProgressOf(s));
  const film::Status status = film::writeShard(wanted_.file, s.film, info);
  secondsThen_ = seconds;
  passesThen_ = passes_;
  if (!status.ok())
    diagnostics.warning("RENDER-CHECKPOINT", {}, status.what, "there is no newer checkpoint",
                        "room and rights in the folder of the picture");
  else if (wanted_.wasWritten)
    wanted_.wasWritten();
}

void Checkpoints::remove() const {
  std::error_code ignored;
  if (wanted_.isOn() && !wanted_.keepsFile) std::filesystem::remove(wanted_.file, ignored);
}

}  // namespace kinora::render
