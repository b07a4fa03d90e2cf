// What merging finds (plugins/integrator/parts/merge_index.h, merge_search.h) against a look at every vertex: on surfaces and in space,
// with radii that are alike and that grow across the powers of two at which cells change, at places of either sign and far
// from the origin, built in another order of its parts. Each vertex is found once. Two widths find the same in
// the same order. It misses wider kernels (the tests of Vcm have them).
#include "plugins/integrator/parts/merge_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <random>
#include <set>
#include <vector>

namespace kinora::vcm {
namespace {

struct Host {
  std::vector<std::unique_ptr<std::byte[]>> blocks;
};

CommitServices servicesOf(Host& host) {
  CommitServices s{};
  s.host = &host;
  s.allocate = [](const CommitServices* c, uint64_t bytes) -> void* {
    auto& blocks = static_cast<Host*>(c->host)->blocks;
    blocks.push_back(std::make_unique<std::byte[]>(bytes));
    return blocks.back().get();
  };
  // as if threads had taken them in another order
  s.parallelFor = [](const CommitServices*, uint64_t n, void* context, void (*body)(void*, uint64_t)) {
    for (uint64_t i = n; i-- > 0;) body(context, i);
  };
  return s;
}

// Radii are `grows` times the distance from the origin, as those of pixels are, or all the same.
void expectFoundOnce(uint32_t count, bool isFlat, float at, float size, float grows) {
  std::mt19937 random(count + 7 * uint32_t(isFlat));
  std::uniform_real_distribution<float> in(-size, size);
  const auto radiusAt = [&](const float P[3]) {
    return grows > 0 ? grows * std::sqrt(P[0] * P[0] + P[1] * P[1] + P[2] * P[2]) + 1e-3f : size / (isFlat ? 40 : 12);
  };
  const auto place = [&](float P[3]) {
    for (int k = 0; k < 3; ++k) P[k] = at + in(random);
    if (isFlat) P[1] = at;
  };
  std::vector<Photon> photons(count);
  for (Photon& p : photons) {
    place(p.P);
    p.radius = random() % 8 ? radiusAt(p.P) : 0.f;  // some are not merged
  }
  Host host;
  const CommitServices services = servicesOf(host);
  const MergeIndex* index =
      MergeIndex::build(services, count, [&](uint64_t i) -> const Photon& { return photons[i]; });
  ASSERT_TRUE(index);
  std::vector<MergeIndex::Query> queries(200);
  for (MergeIndex::Query& q : queries) {
    place(q.P);
    q.radius = radiusAt(q.P);
  }
  std::vector<std::vector<uint32_t>> inOrder[2];
  const auto look = [&]<int W>(std::integral_constant<int, W>, std::vector<std::vector<uint32_t>>& to) {
    to.resize(queries.size());
    uint32_t before = 0;
    HWY_NAMESPACE::findNear<W>(*index, uint32_t(queries.size()), queries.data(), grows + 0.01f,
                               [&](uint32_t query, uint32_t n, const uint32_t* entries) {
                                 EXPECT_GE(query, before);
                                 before = query;
                                 for (uint32_t i = 0; i < n; ++i) to[query].push_back(index->records[entries[i]]);
                               });
  };
  look(std::integral_constant<int, 1>(), inOrder[0]);
  look(std::integral_constant<int, 4>(), inOrder[1]);
  EXPECT_EQ(inOrder[0], inOrder[1]);
  std::vector<std::multiset<uint32_t>> found;
  for (const auto& list : inOrder[0]) found.emplace_back(list.begin(), list.end());
  uint64_t total = 0;
  for (size_t k = 0; k < queries.size(); ++k) {
    const auto& [P, radius] = queries[k];
    std::multiset<uint32_t> expected;
    for (uint32_t i = 0; i < count; ++i) {
      float d2 = 0;
      for (int c = 0; c < 3; ++c) d2 += (photons[i].P[c] - P[c]) * (photons[i].P[c] - P[c]);
      if (photons[i].radius > 0 && d2 <= radius * radius) expected.insert(i);
    }
    EXPECT_EQ(found[k], expected) << "at " << P[0] << " " << P[1] << " " << P[2];
    total += expected.size();
  }
  EXPECT_GT(total, 50u) << "too few to say anything";
}

TEST(MergeIndex, FindsEachVertexOnce) {
  for (const bool isFlat : {true, false}) {
    expectFoundOnce(20000, isFlat, 0, 3, 0);
    expectFoundOnce(20000, isFlat, 0, 3, 0.05f);
    expectFoundOnce(20000, isFlat, -70, 2, 0.003f);
    expectFoundOnce(5000, isFlat, 5000, 200, 0);
  }
  expectFoundOnce(3000, true, 0, 1e-3f, 0);  // more within a radius than are told at once
  expectFoundOnce(60000, true, 1, 1e4f, 0);
}

TEST(MergeIndex, OfNothingFindsNothing) {
  Host host;
  const CommitServices services = servicesOf(host);
  const Photon none{};
  const MergeIndex* index = MergeIndex::build(services, 0, [&](uint64_t) -> const Photon& { return none; });
  ASSERT_TRUE(index);
  const MergeIndex::Query query{{0, 0, 0}, 1};
  HWY_NAMESPACE::findNear<4>(*index, 1, &query, 0.01f, [](uint32_t, uint32_t, const uint32_t*) { ADD_FAILURE(); });
}

}  // namespace
}  // namespace kinora::vcm
