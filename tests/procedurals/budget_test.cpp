// Proves: a scene whose archives do not fit in their budget together is the same picture, bit for bit, for any budget,
// threads, widths and groups; what they hold stays within the budget where 16 paths need no more; nothing is read again
// without end; what changes between two readings is named; the plan of what is held next.
// Misses: the memory of the process, which allocators decide about (docs/performance.md has measurements).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "base/memory.h"
#include "procedurals/archives.h"
#include "render/reading_plan.h"

namespace kinora::tests {
namespace {

// Hills of 1,152 triangles on a plain, seen from above.
std::string hill(int number) {
  constexpr int kSide = 24;
  std::string faces, corners, points;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x) {
      const double u = double(x) / kSide - .5, v = double(y) / kSide - .5;
      const double h = .3 * std::exp(-12 * (u * u + v * v)) * (1 + .3 * std::sin(20 * u + number));
      points += std::to_string(u) + " " + std::to_string(h) + " " + std::to_string(v) + " ";
    }
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const int a = y * (kSide + 1) + x;
      faces += "4 ";
      for (const int c : {a, a + 1, a + kSide + 2, a + kSide + 1}) corners += std::to_string(c) + " ";
    }
  return "Bxdf \"PxrDiffuse\" \"b\" \"color diffuseColor\" [" + std::to_string(.2 + .1 * (number % 7)) + " " +
         std::to_string(.2 + .1 * (number % 5)) + " .3]\nPointsPolygons [" + faces + "] [" + corners + "] \"P\" [" +
         points + "]\n";
}

// `side` x `side` hills.
Files hills(int side) {
  std::string placed;
  Files files;
  for (int k = 0; k < side * side; ++k) {
    const std::string name = "hill" + std::to_string(k) + ".rib";
    placed += delayed(std::to_string(k % side - .5 * (side - 1)) + " -1 " + std::to_string(4 + k / side), name,
                      "-.5 .5 0 .4 -.5 .5");
    files[name] = hill(k);
  }
  files["scene.rib"] =
      "Format 64 48 1\nProjection \"perspective\" \"fov\" [60]\nDisplay \"t\" \"openexr\" \"rgba\"\n"
      "Rotate -50 1 0 0\nTranslate 0 " +
      std::to_string(-.6 * side) + " " + std::to_string(-.5) +
      "\nIntegrator \"PxrPathTracer\" \"i\"\nWorldBegin\nAttributeBegin\nRotate -50 1 .3 0\nLight "
      "\"PxrDistantLight\" \"sun\" \"float intensity\" [2]\nAttributeEnd\nLight \"PxrDomeLight\" \"dome\" \"float "
      "intensity\" [.3]\n" +
      placed + "WorldEnd\n";
  return files;
}

TEST(ProceduralBudget, AQuarterOfWhatAPictureNeeds) {
  const Folder folder(hills(8));
  render::Settings settings;
  settings.samplesPerPixel = 4;
  settings.threads = 2;
  const Rendered all = rendered(folder, settings);
  ASSERT_EQ(all.outcome, render::Outcome::Complete) << all.said;
  EXPECT_EQ(all.said, "");
  const uint64_t whole = all.statistics.proceduralMostBytes;
  ASSERT_GT(all.statistics.proceduralsRead, 48u);
  EXPECT_EQ(all.statistics.proceduralsAgain, 0u);
  EXPECT_EQ(all.statistics.proceduralBudget, 0u);
  EXPECT_GE(all.statistics.proceduralLargest, whole / 64);
  for (const uint64_t part : {1, 2, 4}) {
    settings.geometryCacheBytes = whole / part;
    const Rendered r = rendered(folder, settings);
    EXPECT_EQ(r.outcome, render::Outcome::Complete);
    EXPECT_EQ(r.said, "") << part;
    EXPECT_TRUE(r.sums == all.sums) << part;
    EXPECT_EQ(r.statistics.proceduralsRead, all.statistics.proceduralsRead);
    EXPECT_LE(r.statistics.proceduralMostBytes, whole / part * 5 / 4) << part;
    EXPECT_EQ(r.statistics.cameraRays, all.statistics.cameraRays);
    EXPECT_EQ(r.statistics.indirectRays, all.statistics.indirectRays);
    if (part == 1) {
      EXPECT_EQ(r.statistics.proceduralsAgain, 0u);
      continue;
    }
    EXPECT_GT(r.statistics.proceduralsDropped, 0u);
    // two readings for each block of 4 x 4 pixels of each of three passes
    EXPECT_LT(r.statistics.proceduralsAgain, 2 * 3 * (64 * 48 / 16u)) << part;
    render::Settings other = settings;
    other.threads = 1;
    other.width = 4;
    other.groupSize = 64;
    EXPECT_TRUE(rendered(folder, other).sums == all.sums) << part << ", one thread, width 4, groups of 64";
    other.threads = 3;
    other.groupSize = 4096;
    other.bucketOrder = "random";
    EXPECT_TRUE(rendered(folder, other).sums == all.sums) << part << ", three threads, buckets at random";
  }
}

// Which archives are held does not follow from threads.
TEST(ProceduralBudget, ThreadsReadTheSame) {
  const Folder folder(hills(5));
  render::Settings settings;
  settings.samplesPerPixel = 2;
  settings.geometryCacheBytes = rendered(folder, settings).statistics.proceduralMostBytes / 3;
  const Rendered one = rendered(folder, settings);
  settings.threads = 3;
  const Rendered three = rendered(folder, settings);
  EXPECT_GT(one.statistics.proceduralsAgain, 0u);
  EXPECT_EQ(one.statistics.proceduralsAgain, three.statistics.proceduralsAgain);
  EXPECT_EQ(one.statistics.proceduralWorlds, three.statistics.proceduralWorlds);
  EXPECT_EQ(one.statistics.proceduralMostBytes, three.statistics.proceduralMostBytes);
}

// Within a budget that budget() makes of what all takes, which changes no bit.
Rendered renderedWithin(const Folder& folder, uint64_t (*budget)(const render::Statistics& all)) {
  render::Settings settings;
  settings.samplesPerPixel = 2;
  const Rendered all = rendered(folder, settings);
  settings.geometryCacheBytes = budget(all.statistics);
  Rendered r = rendered(folder, settings);
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_TRUE(r.sums == all.sums);
  return r;
}

TEST(ProceduralBudget, LessThanOneArchive) {
  const Folder folder(hills(3));
  const Rendered r = renderedWithin(folder, [](const render::Statistics& all) { return all.proceduralLargest / 2; });
  const size_t at = r.said.find("RENDER-PROCEDURAL-BUDGET");
  EXPECT_NE(at, std::string::npos) << r.said;
  EXPECT_EQ(r.said.find("RENDER-PROCEDURAL-BUDGET", at + 1), std::string::npos) << r.said;
}

// As the scene says it, in KiB.
TEST(ProceduralBudget, TheScenesOwn) {
  Files files = hills(5);
  files["scene.rib"] = "Option \"limits\" \"int geocachememory\" [2500]\n" + files["scene.rib"];
  const Folder folder(files);
  render::Settings settings;
  settings.samplesPerPixel = 1;
  const Rendered r = rendered(folder, settings);
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_EQ(r.statistics.proceduralBudget, 2560000u);
  EXPECT_GT(r.statistics.proceduralsDropped, 0u);
  EXPECT_LE(r.statistics.proceduralBytes, 2560000u);
}

// A half of the limit on memory, or what the geometry cache may hold where that is less. That something is dropped for it
// is proved where the process has a limit of its own: Limits.* in tests/cli.
TEST(ProceduralBudget, AHalfOfTheLimitOnMemoryAtMost) {
  const Folder folder(hills(1));
  const auto budget = [&](uint64_t cache, uint64_t limit) {
    struct Limited {
      explicit Limited(uint64_t bytes) { Memory::setLimit(bytes); }
      ~Limited() { Memory::setLimit(0); }
    } const limited(limit);
    render::Settings settings;
    settings.samplesPerPixel = 1;
    settings.geometryCacheBytes = cache;
    const Rendered r = rendered(folder, settings);
    EXPECT_EQ(r.outcome, render::Outcome::Complete) << r.said;
    return r.statistics.proceduralBudget;
  };
  const uint64_t limit = (Memory::resident() + (uint64_t(1) << 30)) / 2 * 2;
  EXPECT_EQ(budget(0, 0), 0u);
  EXPECT_EQ(budget(0, limit), limit / 2);
  EXPECT_EQ(budget(5000000, limit), 5000000u);
  EXPECT_EQ(budget(limit / 2 + 1, limit), limit / 2);
}

// Records of light paths name what stands in the world: all of it is held, and said to be more than the budget, once.
// Paths that leave no records are as any.
TEST(ProceduralBudget, LightPathsHoldEverything) {
  for (const char* integrator : {"PxrVCM", "PxrUnified"}) {
    Files files = hills(3);
    std::string& scene = files["scene.rib"];
    scene.replace(scene.find("PxrPathTracer"), 13, integrator);
    const Folder folder(files);
    SCOPED_TRACE(integrator);
    const Rendered r =
        renderedWithin(folder, [](const render::Statistics& all) { return all.proceduralMostBytes / 2; });
    const bool isHeld = std::string(integrator) == "PxrVCM";
    EXPECT_EQ(r.statistics.proceduralsDropped == 0, isHeld) << integrator;
    size_t said = 0;
    for (size_t at = 0; (at = r.said.find("nothing that was read is dropped", at)) != std::string::npos; ++at) ++said;
    EXPECT_EQ(said, size_t(isHeld)) << r.said;
  }
}

// Nothing that a path meets lies beside what another one meets.
std::string apart(const std::string& content) {
  return kHead +
         "Integrator \"PxrDirectLighting\" \"i\"\nWorldBegin\nAttributeBegin\nRotate -90 1 0 0\nLight "
         "\"PxrDistantLight\" \"sun\"\nAttributeEnd\n" +
         content + "WorldEnd\n";
}

const std::string kProgram =
    "AttributeBegin\nTranslate -1.2 0 5\nProcedural \"RunProgram\" [\"sh FOLDER/run.sh\" \"x\"] [-.6 .6 -.6 .6 -.6 "
    ".6]\nAttributeEnd\n";

Rendered twoThatChange(const std::string& script, uint64_t budget) {
  const Folder folder({{"a.rib", kBall}});
  std::string program = kProgram;
  program.replace(program.find("FOLDER"), 6, folder.file("."));
  std::ofstream(folder.file("scene.rib")) << apart(program + delayed("1.2 0 5", "a.rib"));
  std::string text = script;
  for (size_t at; (at = text.find("FOLDER")) != std::string::npos;) text.replace(at, 6, folder.file("."));
  std::ofstream(folder.file("run.sh")) << text;
  render::Settings settings;
  settings.samplesPerPixel = 16;  // five passes, each of which meets both
  settings.geometryCacheBytes = budget;
  return rendered(folder, settings, true);
}

size_t countOf(const std::string& what, const std::string& in) {
  size_t n = 0;
  for (size_t at = 0; (at = in.find(what, at)) != std::string::npos; ++at) ++n;
  return n;
}

TEST(ProceduralBudget, WhatChangesBetweenReadingsIsNamedOnce) {
  const uint64_t one =
      twoThatChange("echo Sphere .5 -.5 .5 360\n", 0).statistics.proceduralLargest * 5 / 4;  // not both
  // the archive, whenever the program runs
  Rendered r = twoThatChange("echo \"# $$\" >> FOLDER/a.rib\necho Sphere .5 -.5 .5 360\n", one);
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_GT(r.statistics.proceduralsAgain, 1u);
  EXPECT_EQ(countOf("RENDER-PROCEDURAL-CHANGED", r.said), 1u) << r.said;
  EXPECT_NE(r.said.find("a.rib' has changed"), std::string::npos) << r.said;
  // an archive that is gone
  r = twoThatChange("rm -f FOLDER/a.rib\necho Sphere .5 -.5 .5 360\n", one);
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_NE(r.said.find("a.rib' is not read any more"), std::string::npos) << r.said;
  // what a program prints
  r = twoThatChange("echo .>>FOLDER/n\necho Sphere .5 -.5 .5 $((300+$(wc -l <FOLDER/n)))\n", one);
  EXPECT_EQ(r.outcome, render::Outcome::Complete);
  EXPECT_EQ(countOf("RENDER-PROCEDURAL-CHANGED", r.said), 1u) << r.said;
  EXPECT_NE(r.said.find("run.sh' has changed"), std::string::npos) << r.said;
  // nothing does
  r = twoThatChange("echo Sphere .5 -.5 .5 360\n", one);
  EXPECT_EQ(countOf("RENDER-PROCEDURAL-CHANGED", r.said), 0u) << r.said;
  EXPECT_GT(r.statistics.proceduralsAgain, 0u);
}

// What an archive has wrong is said when it is read first.
TEST(ProceduralBudget, MessagesAreNotRepeated) {
  const Folder folder({{"scene.rib", apart(delayed("-1.2 0 5", "a.rib") + delayed("1.2 0 5", "b.rib"))},
                       {"a.rib", kBall + "Sphere 1 2\n"},
                       {"b.rib", kBoxes}});
  render::Settings settings;
  settings.samplesPerPixel = 4;
  const Rendered all = rendered(folder, settings);
  EXPECT_NE(all.said, "");
  settings.geometryCacheBytes = 1;
  const Rendered r = rendered(folder, settings);
  EXPECT_GT(r.statistics.proceduralsAgain, 0u);
  EXPECT_TRUE(r.sums == all.sums);
  EXPECT_EQ(all.errors, 1u);
  EXPECT_EQ(r.errors, 1u) << r.said;
}

render::WaitingGroup group(std::vector<uint32_t> needs, bool isWhole = false) {
  return {{}, std::move(needs), isWhole, render::WaitingGroup::Turn::Later};
}

using Turn = render::WaitingGroup::Turn;
constexpr uint32_t kNone = render::HeldProcedural::kNone;

TEST(ReadingPlan, NeighboursGoTogether) {
  std::vector<render::WaitingGroup> g = {group({0, 1}), group({1, 2}), group({3}), group({0, 2})};
  std::vector<render::WaitingGroup*> groups;
  for (auto& x : g) groups.push_back(&x);
  const std::vector<render::HeldProcedural> all(4, {10, false, kNone, 0});
  const render::ReadingPlan p = planReading(groups, all, 30);
  // the one that lacks least begins: 3, then 0 and 2
  EXPECT_EQ(p.read, (std::vector<uint32_t>{0, 2, 3}));
  EXPECT_TRUE(p.drop.empty());
  EXPECT_EQ(p.needed, 30u);
  EXPECT_EQ(g[0].turn, Turn::Later);
  EXPECT_EQ(g[1].turn, Turn::Later);
  EXPECT_EQ(g[2].turn, Turn::Now);
  EXPECT_EQ(g[3].turn, Turn::Now);
}

TEST(ReadingPlan, WhatIsNeededLastIsDropped) {
  std::vector<render::WaitingGroup> g = {group({4}), group({1, 2}, true)};
  std::vector<render::WaitingGroup*> groups{&g[0], &g[1]};
  std::vector<render::HeldProcedural> all(5, {10, true, kNone, 0});
  all[4].isHeld = false;
  all[0].lastNeeded = 7;
  all[3].lastNeeded = 2;
  render::ReadingPlan p = planReading(groups, all, 40);
  // the second lacks nothing and goes too
  EXPECT_EQ(p.read, std::vector<uint32_t>{4});
  EXPECT_EQ(p.drop, std::vector<uint32_t>{3});
  // one inside of another goes before it, whatever was needed when
  all[3].lastNeeded = 7;
  all[3].inside = 0;
  p = planReading(groups, all, 30);
  EXPECT_EQ(p.drop, (std::vector<uint32_t>{3, 0}));
}

TEST(ReadingPlan, GroupsThatNeedTooMuchAreHalved) {
  std::vector<render::WaitingGroup> g = {group({0, 1, 2})};
  std::vector<render::WaitingGroup*> groups{&g[0]};
  const std::vector<render::HeldProcedural> all(3, {10, false, kNone, 0});
  render::ReadingPlan p = planReading(groups, all, 20);
  EXPECT_EQ(g[0].turn, Turn::Halves);
  EXPECT_TRUE(p.read.empty());
  g[0].isWhole = true;
  p = planReading(groups, all, 20);
  EXPECT_EQ(g[0].turn, Turn::Now);
  EXPECT_EQ(p.read.size(), 3u);
  EXPECT_EQ(p.needed, 30u);
}

// Groups that find out what they need one by one, at random: all come to an end, within the budget.
TEST(ReadingPlan, AllGroupsComeToAnEnd) {
  std::mt19937 rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    constexpr uint32_t kCount = 60;
    std::vector<render::HeldProcedural> all(kCount);
    uint64_t largest = 0;
    for (uint32_t k = 0; k < kCount; ++k) {
      all[k].bytes = 1 + rng() % 20;
      if (k >= 20) all[k].inside = rng() % 20;
      largest = std::max(largest, all[k].bytes);
    }
    struct Wanted {
      render::WaitingGroup group;
      std::vector<uint32_t> in_order;
    };
    std::vector<Wanted> wanted(40);
    uint64_t most = 0;
    for (Wanted& w : wanted) {
      uint64_t bytes = 0;
      for (int k = 0; k < 5; ++k) w.in_order.push_back(rng() % kCount);
      std::vector<uint32_t> closed = w.in_order;
      for (const uint32_t k : w.in_order)
        if (all[k].inside != kNone) closed.push_back(all[k].inside);
      std::sort(closed.begin(), closed.end());
      closed.erase(std::unique(closed.begin(), closed.end()), closed.end());
      for (const uint32_t k : closed) bytes += all[k].bytes;
      most = std::max(most, bytes);
    }
    uint64_t plans = 0;
    while (!wanted.empty()) {
      ASSERT_LT(++plans, 40 * 10u);
      std::vector<render::WaitingGroup*> groups;
      for (Wanted& w : wanted) {
        // the first that is not there, with what it is inside of
        for (const uint32_t k : w.in_order)
          if (!all[k].isHeld) {
            for (uint32_t n = k; n != kNone; n = all[n].inside) w.group.needs.push_back(n);
            break;
          }
        std::sort(w.group.needs.begin(), w.group.needs.end());
        w.group.needs.erase(std::unique(w.group.needs.begin(), w.group.needs.end()), w.group.needs.end());
        groups.push_back(&w.group);
      }
      const render::ReadingPlan p = planReading(groups, all, most);
      for (const uint32_t k : p.drop) {
        EXPECT_TRUE(all[k].isHeld);
        for (uint32_t inner = 0; inner < kCount; ++inner) EXPECT_FALSE(all[inner].inside == k && all[inner].isHeld);
        all[k].isHeld = false;
      }
      for (const uint32_t k : p.read) {
        EXPECT_FALSE(all[k].isHeld);
        all[k].isHeld = true;
      }
      uint64_t held = 0;
      for (const auto& h : all) held += h.isHeld ? h.bytes : 0;
      EXPECT_LE(held, most);
      for (Wanted& w : wanted)
        if (w.group.turn == Turn::Now)
          for (const uint32_t k : w.group.needs) {
            EXPECT_TRUE(all[k].isHeld);
            all[k].lastNeeded = plans;
          }
      std::erase_if(wanted, [&](const Wanted& w) {
        return w.group.turn == Turn::Now &&
               std::all_of(w.in_order.begin(), w.in_order.end(), [&](uint32_t k) { return all[k].isHeld; });
      });
    }
  }
}

}  // namespace
}  // namespace kinora::tests
