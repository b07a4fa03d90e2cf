// Records between stages: a light stage keeps some, camera samples find those of their own path, an index is made of
// all. The picture is a function of what was kept, so equal bits mean equal order. Memory that runs out and records
// from the wrong stage end as promised.
#include <kinora/integrator.h>
#include <kinora/pattern_author.h>

#include <cstring>

#include "base/memory.h"
#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

struct Record {
  uint32_t path, sample, place, value;
};
uint32_t mixed(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  return x ^ (x >> 15);
}
uint32_t countOf(uint64_t path, uint32_t sample) { return mixed(uint32_t(path) * 31 + sample) % 4; }

// The test's knobs; one render at a time.
bool appendsFromCamera = false;
uint32_t recordsEach = 1;
uint64_t wrong = 0;

struct Index {
  uint64_t count, hash;
};

void lightStage(Group* g, const Services* s) {
  // in turns over the paths, so that a path's records do not lie together
  for (uint32_t place = 0; place < 3; ++place) {
    std::vector<uint32_t> slots;
    std::vector<Record> records;
    for (uint32_t i = 0; i < g->count; ++i)
      if (place < countOf(g->number[i], g->paths.sampleIndex[i]))
        for (uint32_t k = 0; k < recordsEach; ++k) {
          slots.push_back(i);
          records.push_back({uint32_t(g->number[i]), g->paths.sampleIndex[i], place, g->paths.sampleSeed[i]});
        }
    s->append(g, 0, uint32_t(slots.size()), slots.data(), records.data());
  }
}

void cameraStage(Group* g, const Services* s) {
  std::vector<uint64_t> first(g->count);
  std::vector<uint32_t> count(g->count);
  s->findStored(g, 0, g->count, g->number, g->paths.sampleIndex, first.data(), count.data());
  const StoredRecords all = s->stored(g, 0);
  const auto* records = static_cast<const Record*>(all.records);
  const auto* index = static_cast<const Index*>(s->index(g));
  auto* value = static_cast<float*>(s->alloc(g, g->padded * sizeof(float)));
  auto* words = static_cast<uint32_t*>(s->alloc(g, 3 * g->padded * sizeof(uint32_t)));
  uint64_t bad = !index || index->count != all.count;
  for (uint32_t i = 0; i < g->count; ++i) {
    uint32_t hash = index ? uint32_t(index->hash) : 0;
    const bool isInside = g->pixel[0][i] < s->resolution[0] && g->pixel[1][i] < s->resolution[1];
    if (isInside && count[i] != countOf(g->number[i], g->paths.sampleIndex[i]) * recordsEach) ++bad;
    for (uint32_t k = 0; k < count[i]; ++k) {
      const Record& r = records[first[i] + k];
      bad += r.path != g->number[i] || r.sample != g->paths.sampleIndex[i] || r.place != k / recordsEach;
      hash = mixed(hash ^ r.value);
    }
    value[i] = float(hash >> 20) / 4096;
    words[i] = i;
    words[g->padded + i] = s->paths.start;
    words[2 * g->padded + i] = kNoLight;
  }
  const Contributions out{g->count, words, {value, value, value}, words + g->padded, words + 2 * g->padded};
  s->contribute(g, &out);
  if (appendsFromCamera) {
    const Record r{};
    const uint32_t slot = 0;
    s->append(g, 0, 1, &slot, &r);
    s->append(g, 7, 1, &slot, &r);
  }
  if (bad) __atomic_fetch_add(&wrong, bad, __ATOMIC_RELAXED);
}

void integrate(const void*, uint32_t stage, Group* g, const Services* s) {
  stage == 0 ? lightStage(g, s) : cameraStage(g, s);
}
void commit(const void*, uint32_t stage, const CommitServices* s) {
  if (stage != 0) return;
  const StoredRecords all = s->stored(s, 0);
  struct Sums {
    const Record* records;
    uint64_t* parts;
    uint64_t count;
  };
  constexpr uint64_t kParts = 16;
  auto* index = static_cast<Index*>(s->allocate(s, sizeof(Index)));
  auto* parts = static_cast<uint64_t*>(s->allocate(s, kParts * sizeof(uint64_t)));
  if (!index || !parts) return;
  Sums sums{static_cast<const Record*>(all.records), parts, all.count};
  s->parallelFor(s, kParts, &sums, [](void* context, uint64_t part) {
    const Sums& x = *static_cast<Sums*>(context);
    uint64_t h = part;
    for (uint64_t i = x.count * part / kParts; i < x.count * (part + 1) / kParts; ++i)
      h = h * 0x9E3779B97F4A7C15u + x.records[i].value + x.records[i].place;
    x.parts[part] = h;
  });
  *index = {all.count, 0};
  for (uint64_t k = 0; k < kParts; ++k) index->hash = index->hash * 31 + parts[k];
  index->hash ^= index->hash >> 32;
  s->setIndex(s, index);
}
uint32_t stages(const void*, Stage* out, uint32_t capacity) {
  if (capacity < 2) return 0;
  out[0] = {StageKind::LightPaths, 1};
  out[1] = {StageKind::CameraPaths, 0};
  return 2;
}
uint32_t lists(const void*, RecordList* out, uint32_t) {
  out[0] = {sizeof(Record), 0};
  return 1;
}
constexpr IntegratorFunctions kFunctions{&integrate, &commit};
constexpr IntegratorTraits kTraits{&stages, &lists, 2};
constexpr Descriptor kProbe = probeOf<kFunctions>("ProbeStore", "Keeps records.", kTraits);

const char* const kScene = R"(
Hider "raytrace" "int maxsamples" [8]
Display "probe.exr" "openexr" "Ci,a"
Format 50 38 1
PixelFilter "box" 1 1
WorldBegin
  Light "PxrDomeLight" "sky"
  Bxdf "PxrDiffuse" "grey"
  Sphere 1 -1 1 360
WorldEnd
)";

render::Settings settingsOf(int threads, uint32_t group, const char* order = "horizontal") {
  render::Settings s;
  s.threads = threads;
  s.integrator = "ProbeStore";
  if (group) s.groupSize = group;
  s.bucketOrder = order;
  return s;
}

TEST(PassStore, OrderIsThatOfSamplesAndPaths) {
  wrong = 0;
  std::vector<int64_t> first;
  for (const auto& s : {settingsOf(1, 0), settingsOf(2, 64), settingsOf(2, 1000, "spiral")}) {
    Workshop stage{&kProbe};
    const auto r = stage.load(sceneOf(kScene, stage.messages), s);
    ASSERT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
    const std::vector<int64_t> state = stateOf(r->film());
    if (first.empty()) first = state;
    EXPECT_EQ(state, first) << s.groupSize;
  }
  EXPECT_EQ(wrong, 0u);
}

// Replay makes the records of the sample's pass again.
TEST(PassStore, ReplayRunsTheStagesBefore) {
  Workshop stage{&kProbe};
  const auto r = stage.load(sceneOf(kScene, stage.messages), settingsOf(1, 0));
  ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
  wrong = 0;
  std::string said;
  for (const int sample : {0, 3, 6}) EXPECT_TRUE(r->replay(20, 17, sample, [&](const std::string& l) { said += l; }));
  EXPECT_EQ(wrong, 0u);
  EXPECT_NE(said.find("sample Ci"), std::string::npos) << said;
}

TEST(PassStore, WrongListsAreDroppedAndTold) {
  appendsFromCamera = true;
  Workshop stage{&kProbe};
  const auto r = stage.load(sceneOf(kScene, stage.messages), settingsOf(2, 0));
  EXPECT_EQ(r->renderFilm(), render::Outcome::Complete);
  appendsFromCamera = false;
  EXPECT_NE(stage.said.find("RENDER-RECORDS"), std::string::npos) << stage.said;
}

TEST(PassStore, MemoryThatRunsOutEndsTheFrame) {
  Workshop stage{&kProbe};
  const auto r = stage.load(sceneOf(kScene, stage.messages), settingsOf(2, 0));
  Memory::setLimit(Memory::resident() + (uint64_t(32) << 20));
  recordsEach = 2000;
  EXPECT_EQ(r->renderFilm(), render::Outcome::OutOfMemory);
  recordsEach = 1;
  Memory::setLimit(0);
  EXPECT_NE(stage.said.find("MEMORY-LIMIT"), std::string::npos) << stage.said;
}

}  // namespace
}  // namespace kinora::probes
