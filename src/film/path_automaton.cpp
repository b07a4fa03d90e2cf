#include "film/path_automaton.h"

#include <algorithm>
#include <map>
#include <set>

namespace kinora::film {
namespace {

// One event as patterns are held against it.
struct Symbol {
  PathEventKind kind = PathEventKind::Scatter;
  uint8_t types = 0;
  uint32_t lobes = 0;
  const std::string* labels[2] = {nullptr, nullptr};
};

bool takes(const PathAtom& atom, const Symbol& s) {
  const auto one = [&](const PathPattern& p) {
    if (p.kind != s.kind) return false;
    if (p.kind == PathEventKind::Scatter && (!(p.types & s.types) || !(p.lobes & s.lobes))) return false;
    if (!p.label) return true;
    return (s.labels[0] && *s.labels[0] == *p.label) || (s.labels[1] && *s.labels[1] == *p.label);
  };
  const bool found = std::any_of(atom.patterns.begin(), atom.patterns.end(), one);
  // "[^D]" is any event of a path but those; signals of user lobes are none unless they are named
  if (atom.isNegated && (s.kind == PathEventKind::Camera || (s.lobes & kUserLobes))) return false;
  return found != atom.isNegated;
}

// Thompson's construction (1968) over all expressions; atoms are numbered over all of them.
struct Net {
  struct Node {
    int atom = -1, to = -1;  // an edge that takes an event, or
    int free[2] = {-1, -1};  // up to two that take none
    int ends = -1;           // the expression that is matched here
  };
  std::vector<Node> nodes;
  std::vector<const PathAtom*> atoms;
  std::vector<int> starts;
  bool isFull = false;
  mutable size_t work = 0;  // nodes visited: bounds the time that hostile expressions take

  int node() {
    if (nodes.size() >= PathAutomaton::kMostNodes) isFull = true;
    nodes.emplace_back();
    return int(nodes.size()) - 1;
  }
  // Adds the part `n` of `e` from `from`; returns its end.
  int add(const PathExpression& e, int n, int from, int firstAtom) {
    if (isFull) return from;
    const PathNode& p = e.nodes[size_t(n)];
    switch (p.kind) {
      case PathNode::Kind::Atom: {
        const int to = node();
        nodes[size_t(from)].atom = firstAtom + p.atom;
        nodes[size_t(from)].to = to;
        return link(to);
      }
      case PathNode::Kind::Sequence:
        for (const int c : p.children) from = add(e, c, from, firstAtom);
        return from;
      case PathNode::Kind::Choice: {
        std::vector<int> begins, ends;
        int fork = from;
        for (size_t i = 0; i < p.children.size(); ++i) {
          const int begin = node();
          nodes[size_t(fork)].free[0] = begin;
          ends.push_back(add(e, p.children[i], begin, firstAtom));
          if (i + 1 < p.children.size()) {
            const int more = node();
            nodes[size_t(fork)].free[1] = more;
            fork = more;
          }
        }
        const int to = node();
        for (const int x : ends) nodes[size_t(x)].free[0] = to;
        return link(to);
      }
      case PathNode::Kind::Repeat: {
        for (int i = 0; i < p.least; ++i) from = add(e, p.children[0], from, firstAtom);
        if (p.most < 0) {
          const int begin = node(), to = node();
          nodes[size_t(from)].free[0] = begin;
          nodes[size_t(from)].free[1] = to;
          const int back = add(e, p.children[0], begin, firstAtom);
          nodes[size_t(back)].free[0] = begin;
          nodes[size_t(back)].free[1] = to;
          return link(to);
        }
        std::vector<int> skips;
        for (int i = p.least; i < p.most; ++i) {
          const int begin = node();
          nodes[size_t(from)].free[0] = begin;
          skips.push_back(from);
          from = add(e, p.children[0], begin, firstAtom);
        }
        const int to = node();
        nodes[size_t(from)].free[0] = to;
        for (const int x : skips) nodes[size_t(x)].free[1] = to;
        return link(to);
      }
    }
    return from;
  }
  // A fresh node behind `n`, so that whoever goes on never finds its edges taken.
  int link(int n) {
    const int to = node();
    nodes[size_t(n)].free[0] = to;
    return to;
  }

  using Set = std::vector<int>;  // sorted
  Set closure(Set from) const {
    std::vector<uint8_t> in(nodes.size(), 0);
    Set open = from, all;
    while (!open.empty()) {
      const int n = open.back();
      open.pop_back();
      if (in[size_t(n)]) continue;
      in[size_t(n)] = 1;
      ++work;
      for (const int f : nodes[size_t(n)].free)
        if (f >= 0) open.push_back(f);
      // only what takes an event or ends an expression tells sets apart
      if (nodes[size_t(n)].atom >= 0 || nodes[size_t(n)].ends >= 0) all.push_back(n);
    }
    std::sort(all.begin(), all.end());
    return all;
  }
  template <class Takes>
  Set step(const Set& s, Takes takesAtom) const {
    Set to;
    for (const int n : s)
      if (nodes[size_t(n)].atom >= 0 && takesAtom(size_t(nodes[size_t(n)].atom))) to.push_back(nodes[size_t(n)].to);
    return closure(std::move(to));
  }
};

}  // namespace

uint32_t PathAutomaton::rawEvent(uint8_t types, int lobe, int surface, int name) const {
  const uint32_t l = uint32_t(labels_.size()) + 1;
  const uint32_t type = types == kPathReflect ? 0 : types == kPathTransmit ? 1 : 2;
  return ((type * uint32_t(kFirstUserLobe) + uint32_t(lobe)) * l + uint32_t(surface + 1)) * l + uint32_t(name + 1);
}

uint32_t PathAutomaton::event(uint8_t types, int lobe, int surface, int name) const {
  return eventOfRaw_[rawEvent(types, lobe, surface, name)];
}

bool PathAutomaton::build(const std::vector<PathExpression>& list, bool splitSpecular) {
  Net net;
  std::set<std::string> labels, groups;
  for (size_t i = 0; i < list.size(); ++i) {
    const PathExpression& e = list[i];
    const int firstAtom = int(net.atoms.size());
    for (const PathAtom& a : e.atoms) {
      net.atoms.push_back(&a);
      for (const PathPattern& p : a.patterns)
        if (p.label) (p.kind == PathEventKind::Scatter ? labels : groups).insert(*p.label);
    }
    const int start = net.node();
    net.starts.push_back(start);
    const int end = net.add(e, e.root, start, firstAtom);
    net.nodes[size_t(end)].ends = int(i);
  }
  if (net.isFull || labels.size() > kMostLabels || groups.size() > 1000) return false;
  labels_.assign(labels.begin(), labels.end());
  lightGroups_.assign(groups.begin(), groups.end());

  // Events that all atoms treat alike are one.
  const int labelCount = int(labels_.size());
  const auto label = [&](int i) { return i < 0 ? nullptr : &labels_[size_t(i)]; };
  std::vector<std::vector<bool>> signatures;
  std::map<std::vector<bool>, uint32_t> classOf;
  std::vector<uint32_t> classOfRaw(3u * uint32_t(kFirstUserLobe) * uint32_t(labelCount + 1) *
                                   uint32_t(labelCount + 1));
  for (const uint8_t type : {kPathReflect, kPathTransmit, kPathVolume})
    for (int lobe = 0; lobe < kFirstUserLobe; ++lobe)
      for (int a = -1; a < labelCount; ++a)
        for (int b = -1; b < labelCount; ++b) {
          const Symbol s{PathEventKind::Scatter, type, 1u << lobe, {label(a), label(b)}};
          std::vector<bool> signature(net.atoms.size());
          for (size_t k = 0; k < net.atoms.size(); ++k) signature[k] = takes(*net.atoms[k], s);
          const auto [it, isNew] = classOf.try_emplace(signature, uint32_t(signatures.size()));
          if (isNew) signatures.push_back(signature);
          classOfRaw[rawEvent(type, lobe, a, b)] = it->second;
        }
  const uint32_t classes = uint32_t(signatures.size());

  // Sets of nodes become states. The first one is told from all others: light seen from there is seen directly.
  const Symbol camera{PathEventKind::Camera, 0, 0, {nullptr, nullptr}};
  Net::Set begin = net.closure(net.starts);
  begin = net.step(begin, [&](size_t atom) { return takes(*net.atoms[atom], camera); });
  std::vector<Net::Set> sets{begin};
  std::map<Net::Set, uint32_t> known;
  std::vector<uint32_t> step;  // by state and class
  for (size_t s = 0; s < sets.size(); ++s)
    for (uint32_t c = 0; c < classes; ++c) {
      const Net::Set to = net.step(sets[s], [&](size_t atom) { return bool(signatures[c][atom]); });
      const auto [it, isNew] = known.try_emplace(to, uint32_t(sets.size()));
      if (isNew) sets.push_back(to);
      if (sets.size() > kMostStates || net.work > 20'000'000) return false;
      step.push_back(it->second);
    }

  // What each state takes at its ends, and which state stands for which (Moore's refinement).
  const uint32_t ends = this->ends();
  std::vector<std::vector<std::vector<uint16_t>>> taken(sets.size(), std::vector<std::vector<uint16_t>>(ends));
  matches_.assign(list.size(), 0);
  const auto endsOf = [&](const Net::Set& s, const Symbol& end, std::set<uint16_t>& out) {
    for (const int n : net.step(s, [&](size_t atom) { return takes(*net.atoms[atom], end); }))
      if (net.nodes[size_t(n)].ends >= 0) out.insert(uint16_t(net.nodes[size_t(n)].ends));
  };
  for (size_t s = 0; s < sets.size(); ++s)
    for (uint32_t e = 0; e < ends; ++e) {
      std::set<uint16_t> out;
      const std::string* group = e >= 2 ? &lightGroups_[e - 2] : nullptr;
      const Symbol light{PathEventKind::Light, 0, 0, {group, nullptr}},
          object{PathEventKind::Object, 0, 0, {group, nullptr}};
      // "O": glow, and lights that the camera sees, which are in no "L" then: each light is counted once
      endsOf(sets[s], e == 0 || s == 0 ? object : light, out);
      taken[s][e].assign(out.begin(), out.end());
      for (const uint16_t i : out) matches_[i] = 1;
    }
  std::vector<uint32_t> part(sets.size());
  uint32_t parts = 0;
  for (;;) {
    std::map<std::vector<uint32_t>, uint32_t> ids;
    std::map<std::vector<std::vector<uint16_t>>, uint32_t> outputs;
    std::vector<uint32_t> next(sets.size());
    for (size_t s = 0; s < sets.size(); ++s) {
      std::vector<uint32_t> key;
      if (parts == 0) {
        key = {uint32_t(s == 0), outputs.try_emplace(taken[s], uint32_t(outputs.size())).first->second};
      } else {
        key.push_back(part[s]);
        for (uint32_t c = 0; c < classes; ++c) key.push_back(part[step[s * classes + c]]);
      }
      next[s] = ids.try_emplace(key, uint32_t(ids.size())).first->second;  // numbered as met: state 0 stays 0
    }
    part = next;
    if (ids.size() == parts) break;
    parts = uint32_t(ids.size());
  }
  states_ = parts;
  std::vector<size_t> someSet(parts);
  for (size_t s = sets.size(); s-- > 0;) someSet[part[s]] = s;
  accepted_.assign(size_t(parts) * ends, {});
  for (uint32_t p = 0; p < parts; ++p)
    for (uint32_t e = 0; e < ends; ++e) accepted_[p * ends + e] = taken[someSet[p]][e];

  // Classes that lead everywhere to the same state are one event.
  std::map<std::vector<uint32_t>, uint32_t> columns;
  std::vector<uint32_t> mergedOf(classes);
  std::vector<std::vector<uint32_t>> columnOf;
  for (uint32_t c = 0; c < classes; ++c) {
    std::vector<uint32_t> column(parts);
    for (uint32_t p = 0; p < parts; ++p) column[p] = part[step[someSet[p] * classes + c]];
    const auto [it, isNew] = columns.try_emplace(column, uint32_t(columnOf.size()));
    if (isNew) columnOf.push_back(column);
    mergedOf[c] = it->second;
  }
  // Bit 0 of the event: specular. An event that both kinds share has it only when they must be told apart.
  std::vector<uint8_t> kinds(columnOf.size(), 0);
  for (uint32_t raw = 0; raw < classOfRaw.size(); ++raw) {
    const int lobe = int(raw / uint32_t((labelCount + 1) * (labelCount + 1))) % kFirstUserLobe;
    kinds[mergedOf[classOfRaw[raw]]] |= lobe < kFirstSpecularLobe ? 1 : 2;
  }
  events_ = 2 * uint32_t(columnOf.size());
  eventOfRaw_.resize(classOfRaw.size());
  for (uint32_t raw = 0; raw < classOfRaw.size(); ++raw) {
    const int lobe = int(raw / uint32_t((labelCount + 1) * (labelCount + 1))) % kFirstUserLobe;
    const uint32_t merged = mergedOf[classOfRaw[raw]];
    const bool isSpecular = lobe >= kFirstSpecularLobe && (splitSpecular || kinds[merged] == 2);
    eventOfRaw_[raw] = uint16_t(2 * merged + isSpecular);
  }
  next_.resize(size_t(parts) * events_);
  for (uint32_t p = 0; p < parts; ++p)
    for (uint32_t e = 0; e < events_; ++e) next_[p * events_ + e] = columnOf[e / 2][p];

  userLobes_.assign(list.size(), 0);
  for (uint32_t n = 0; n < uint32_t(kPathLobes - kFirstUserLobe); ++n) {
    const Symbol user{PathEventKind::Scatter, kPathReflect, 1u << (uint32_t(kFirstUserLobe) + n), {nullptr, nullptr}};
    const Symbol light{PathEventKind::Light, 0, 0, {nullptr, nullptr}};
    std::set<uint16_t> out;
    endsOf(net.step(begin, [&](size_t atom) { return takes(*net.atoms[atom], user); }), light, out);
    for (const uint16_t i : out) {
      userLobes_[i] |= 1u << n;
      matches_[i] = 1;
    }
  }
  return true;
}

}  // namespace kinora::film
