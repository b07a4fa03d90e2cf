#include "scene/identity.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <set>

#include "scene/digester.h"
#include "scene/fields.h"

namespace kinora::scene {

bool optionDecidesPixels(const Parameter& option) {
  static constexpr std::string_view kGroups[] = {
      "searchpath:", "statistics:", "ribparse:", "rib:", "bucket:", "checkpoint:"};
  static constexpr std::string_view kNames[] = {"limits:bucketsize",     "limits:threads",     "limits:texturememory",
                                                "limits:geocachememory", "limits:brickmemory", "limits:rendertime",
                                                "shader:cache"};
  const std::string_view name = option.name;
  return std::none_of(std::begin(kGroups), std::end(kGroups),
                      [&](std::string_view group) { return name.starts_with(group); }) &&
         std::find(std::begin(kNames), std::end(kNames), name) == std::end(kNames);
}

bool hiderDecidesPixels(const Parameter& parameter) {
  return parameter.name != "sampleoffset" && parameter.name != "samplestride";
}

namespace {

std::string inQuotes(const std::string& what, const std::string& name) { return what + " \"" + name + "\""; }
std::string placeOf(const SourcePos& pos) { return pos.str(); }

std::string titleOf(const Node& n) {
  return inQuotes(n.kind.empty() ? "node" : n.kind, n.handle.empty() ? n.plugin : n.handle);
}

// The digests of a thing's fields, by names that people know.
class PartLister {
 public:
  PartLister(Digester& digester, std::vector<Inventory::Part>& to) : digester_(digester), to_(to) {}

  template <class T>
  void list(const T& value, const std::string& before = {}) {
    if constexpr (std::is_same_v<T, Node>) {
      Hasher which;
      for (const std::string* s : {&value.kind, &value.plugin, &value.handle}) which.text(*s);
      put(before.empty() ? "plug-in" : before.substr(0, before.size() - 2), which.result());
      for (const Parameter& p : value.params)
        if (!isHider(value) || hiderDecidesPixels(p)) put(inQuotes(before + "parameter", p.name), digester_.of(p));
    } else if constexpr (Described<T>) {
      static const T kUsual{};
      forEachField(value, [&]<class F>(const F& field, const typename F::Member& member) {
        if constexpr (F::kCounts != Counts::Never && !F::kIsPart)
          listNamed(field, member, kUsual.*field.member, before);
        // of the nodes of a network each says which it is
        if constexpr (F::kIsPart && std::is_same_v<T, Network>)
          listElements(member, before);
        else if constexpr (F::kIsPart)
          list(member, before);
      });
    } else if constexpr (IsVector<T>::value) {
      listElements(value, before);
    } else if constexpr (std::is_same_v<T, Shape>) {
      put(before + "kind of shape", digester_.of(uint64_t(value.index())));
      std::visit([&](const auto& shape) { list(shape, before); }, value);
    } else if constexpr (IsShared<T>::value || detail::IsOptional<T>::value) {
      if (value) list(*value, before);
    } else {
      static_assert(sizeof(T) == 0, "a part has fields of its own");
    }
  }

 private:
  void put(std::string name, const Digest& d) { to_.push_back({std::move(name), uint32_t(d.low)}); }

  // What is as usual is not listed: of most things that is most of them.
  template <class F, class M>
  void listNamed(const F& field, const M& value, const M& usual, const std::string& before) {
    const auto putUnusual = [&](const std::string& name) {
      const Digest d = digester_.of(field, value);
      if (d != digester_.of(field, usual)) put(name, d);
    };
    const std::string name = before + std::string(field.name);
    if constexpr (std::is_same_v<M, ParameterList>) {
      for (const Parameter& p : value) put(inQuotes(name, p.name), digester_.of(p));
    } else if constexpr (IsShared<M>::value) {
      if (!value) return;
      if constexpr (IsMap<std::remove_const_t<typename M::element_type>>::value)
        for (const auto& [key, one] : *value) put(inQuotes(name, key), digester_.of(one));
      else
        putUnusual(name);
    } else {
      putUnusual(name);
    }
  }

  template <class T>
  void listElements(const T& one, const std::string& before) {
    if constexpr (IsVector<T>::value)
      for (const auto& element : one) listElements(element, before);
    else if constexpr (IsShared<T>::value) {
      if (one) listElements(*one, before);
    } else if constexpr (std::is_same_v<T, Node>) {
      list(one, before + titleOf(one) + ": ");
    } else if constexpr (std::is_same_v<T, SubdivisionMesh::Tag>) {
      list(one, before + inQuotes("tag", one.name) + ": ");
    } else {
      list(one, before);
    }
  }

  Digester& digester_;
  std::vector<Inventory::Part>& to_;
};

// What a thing is called, and where it was said.
struct Title {
  std::string name, place;
};
Title titleOf(const Primitive& p, const Scene&) {
  const std::string name = p.givenName();
  return {name.empty() ? requestName(p.shape) : inQuotes("object", name), placeOf(p.pos)};
}
Title titleOf(const Light& l, const Scene&) {
  if (!l.node) return {"light", ""};
  return {inQuotes("light", l.node->handle.empty() ? l.node->plugin : l.node->handle), placeOf(l.node->pos)};
}
Title titleOf(const Instance& i, const Scene& s) {
  return {inQuotes("instance of object", i.prototype < s.prototypes.size() ? s.prototypes[i.prototype].name : ""),
          placeOf(i.pos)};
}
Title titleOf(const Solid& s, const Scene&) { return {"solid", placeOf(s.pos)}; }
Title titleOf(const Node& n, const Scene&) { return {titleOf(n), placeOf(n.pos)}; }
Title titleOf(const Camera& c, const Scene&) { return {inQuotes("camera", c.name), placeOf(c.pos)}; }
Title titleOf(const Display& d, const Scene&) { return {inQuotes("display", d.file), placeOf(d.pos)}; }
Title titleOf(const DisplayChannel& c, const Scene&) { return {inQuotes("display channel", c.name), placeOf(c.pos)}; }
Title titleOf(const KeptRequest& k, const Scene&) { return {"request " + k.request, placeOf(k.pos)}; }

// One thing of a scene, of any type. A million of them are made for a large scene: names come when they are asked
// for.
struct Thing;
struct Section {
  std::string_view field;  // of Scene
  size_t first = 0, end = 0;
};
struct ThingType {
  Digest (*digest)(Digester&, const Thing&);
  Title (*title)(const Thing&, const Section&, const Scene&);
  void (*parts)(PartLister&, const Thing&);  // null: it has none
};
struct Thing {
  const void* object;  // of an instance: the list that it is in
  const ThingType* type;
  const std::string* key;  // in its section, or the object that it stands in; null: none
  size_t place = 0;        // of an instance, in its list
  template <class T>
  decltype(auto) as() const {
    if constexpr (std::is_same_v<T, Instance>)
      return (*static_cast<const InstanceList*>(object))[place];
    else
      return *static_cast<const T*>(object);
  }
};

// All things of a scene in the order of its fields; a section for each field. Lists of instances are one entry each,
// since there are millions of them.
class Things {
 public:
  explicit Things(const Scene& scene) {
    forEachField(scene, [&]<class F>(const F& field, const typename F::Member& member) {
      if constexpr (F::kCounts != Counts::Never) {
        const size_t first = size();
        add(field, member);
        sections.push_back({field.name, first, size()});
      }
    });
  }
  size_t size() const { return single_.size() + instances_; }
  Thing operator[](size_t i) const {
    const auto after = std::upper_bound(lists_.begin(), lists_.end(), i,
                                        [](size_t place, const List& l) { return place < l.first; });
    if (after == lists_.begin()) return single_[i];
    const List& l = *(after - 1);
    if (i - l.first >= l.count) return single_[i - l.first - l.count + l.singleBefore];
    Thing t = l.firstOf;
    t.place = i - l.first;
    return t;
  }
  std::vector<Section> sections;

 private:
  struct List {
    size_t first, count, singleBefore;
    Thing firstOf;
  };
  template <class F, class M>
  void add(const F& field, const M& member) {
    if constexpr (std::is_same_v<M, ParameterList>) {
      for (const Parameter& p : member)
        if (!field.isCounted || field.isCounted(p)) addPlain(p, &p.name);
    } else if constexpr (IsMap<M>::value) {
      for (const auto& [name, one] : member) addPlain(one, &name);
    } else if constexpr (std::is_same_v<M, std::vector<Prototype>>) {
      for (const Prototype& p : member) addPrototype(p);
    } else if constexpr (std::is_same_v<M, NodePtr>) {
      if (member) addThing(*member);
    } else if constexpr (IsVector<M>::value) {
      addAll(member);
    } else {
      addPlain(member, nullptr);
    }
  }
  void addAll(const InstanceList& all, const std::string* within = nullptr) {
    if (all.empty()) return;
    lists_.push_back({size(), all.size(), single_.size(), {&all, typeOf<Instance>(), within}});
    instances_ += all.size();
  }
  template <class T>
  void addAll(const std::vector<T>& all, const std::string* within = nullptr) {
    for (const T& one : all) {
      if constexpr (IsShared<T>::value)
        addThing(*one, within);
      else
        addThing(one, within);
    }
  }
  void addPrototype(const Prototype& p) {
    static constexpr ThingType kType{
        // itself: what stands in it are things of their own
        [](Digester& digester, const Thing& t) {
          Hasher h;
          forEachField(t.as<Prototype>(), [&]<class F>(const F& field, const typename F::Member& member) {
            if constexpr (IsVector<typename F::Member>::value)
              h.word(member.size());
            else
              h.digest(digester.of(field, member));
          });
          return h.result();
        },
        [](const Thing& t, const Section&, const Scene&) {
          const auto& o = t.as<Prototype>();
          return Title{inQuotes("ObjectBegin", o.name), placeOf(o.pos)};
        },
        nullptr};
    single_.push_back({&p, &kType, nullptr});
    forEachField(p, [&](const auto&, const auto& member) {
      if constexpr (IsVector<std::decay_t<decltype(member)>>::value) addAll(member, &p.name);
    });
  }
  template <class T>
  void addThing(const T& object, const std::string* within = nullptr) {
    single_.push_back({&object, typeOf<T>(), within});
  }

 public:
  template <class T>
  static const ThingType* typeOf() {
    static constexpr ThingType kType{[](Digester& d, const Thing& t) { return d.of(t.as<T>()); },
                                     [](const Thing& t, const Section&, const Scene& s) {
                                       Title title = titleOf(t.as<T>(), s);
                                       if (t.key) title.name += inQuotes(" of ObjectBegin", *t.key);
                                       return title;
                                     },
                                     [](PartLister& l, const Thing& t) { l.list(t.as<T>()); }};
    return &kType;
  }

 private:
  template <class T>
  void addPlain(const T& value, const std::string* key) {
    static constexpr ThingType kType{[](Digester& d, const Thing& t) { return d.of(t.as<T>()); },
                                     [](const Thing& t, const Section& section, const Scene&) {
                                       const std::string name(section.field);
                                       return Title{t.key ? inQuotes(name, *t.key) : name, ""};
                                     },
                                     nullptr};
    single_.push_back({&value, &kType, key});
  }

  std::vector<Thing> single_;
  std::vector<List> lists_;
  size_t instances_ = 0;
};

// A key that a thing stands under counts as well.
Digest digestOf(const Thing& t, const Digest& own) {
  Hasher h;
  h.digest(own);
  if (t.key) h.text(*t.key);
  return h.result();
}

bool isPrimitive(const Thing& t) { return t.type == Things::typeOf<Primitive>(); }

// What a thing's digest depends on beside the thing.
Digest digestOf(const Surroundings& s, const Scene& scene) {
  std::map<std::string_view, Digest> sorted(s.files.begin(), s.files.end());
  Hasher h;
  for (const auto& [name, content] : sorted) h.text(name), h.digest(content);
  h.word(scene.classicLights.size());
  for (const Light& l : scene.classicLights) h.word(l.id);
  if (!scene.classicLights.empty())
    for (const PrimitivePtr& p : scene.primitives) h.word(p->id);
  return h.result();
}

// The things' own digests, to be asked for in their order: so many at a time are made and kept, by all threads.
class DigestsInTurn {
 public:
  DigestsInTurn(const Things& things, const Surroundings& s, const PrimitiveDigests* remembered = nullptr)
      : things_(things), s_(s), remembered_(remembered) {}
  const Digest& operator[](size_t i) {
    if (i < first_ || i >= first_ + made_.size()) make(i);
    return made_[i - first_];
  }

 private:
  void make(size_t first) {
    constexpr size_t kChunk = 1024, kAtATime = 128 * kChunk;
    first_ = first;
    made_.resize(std::min(kAtATime, things_.size() - first));
    tbb::parallel_for(size_t(0), (made_.size() + kChunk - 1) / kChunk, [&](size_t chunk) {
      Digester digester(s_);
      for (size_t i = chunk * kChunk; i < std::min(made_.size(), (chunk + 1) * kChunk); ++i) {
        const Thing t = things_[first + i];
        if (remembered_ && isPrimitive(t))
          if (const auto it = remembered_->known.find(static_cast<const Primitive*>(t.object));
              it != remembered_->known.end()) {
            made_[i] = it->second.digest;
            continue;
          }
        made_[i] = t.type->digest(digester, t);
      }
    });
  }

  const Things& things_;
  const Surroundings& s_;
  const PrimitiveDigests* remembered_;
  size_t first_ = 0;
  std::vector<Digest> made_;
};

// Those of the scene's primitives.
void remember(const Scene& scene, const std::unordered_map<const void*, Digest>& own, PrimitiveDigests& to) {
  std::unordered_map<const Primitive*, PrimitiveDigests::Known> now;
  const auto add = [&](const std::vector<PrimitivePtr>& list) {
    for (const PrimitivePtr& p : list) now.try_emplace(p.get(), PrimitiveDigests::Known{p, own.at(p.get())});
  };
  add(scene.primitives);
  for (const Prototype& p : scene.prototypes) add(p.primitives);
  to.known = std::move(now);
}

}  // namespace

Digest digestOf(const Scene& scene, const ContentsByName& files, PrimitiveDigests* remembered) {
  const Surroundings s{files, Places(scene)};
  const Things things(scene);
  if (remembered)
    if (const Digest around = digestOf(s, scene); around != remembered->surroundings) {
      remembered->known.clear();
      remembered->surroundings = around;
    }
  DigestsInTurn digests(things, s, remembered);
  std::unordered_map<const void*, Digest> ofPrimitives;
  Hasher h;
  for (const Section& section : things.sections) {
    h.word(section.end - section.first);
    for (size_t i = section.first; i < section.end; ++i) {
      const Thing t = things[i];
      h.digest(digestOf(t, digests[i]));
      if (remembered && isPrimitive(t)) ofPrimitives.emplace(t.object, digests[i]);
    }
  }
  if (remembered) remember(scene, ofPrimitives, *remembered);
  return h.result();
}

Inventory inventoryOf(const Scene& scene, const ContentsByName& files, const InventorySize& most) {
  const Surroundings s{files, Places(scene)};
  const Things things(scene);
  DigestsInTurn digests(things, s);
  Digester digester(s);
  Inventory inventory;
  for (const Section& section : things.sections) {
    const size_t all = section.end - section.first,
                 size = (all + most.entries - 1) / std::max<size_t>(1, most.entries);
    size_t partsLeft = most.parts;
    for (size_t i = section.first; i < section.end; i += size) {
      const size_t end = std::min(i + size, section.end);
      const Thing t = things[i];
      Title title = t.type->title(t, section, scene);
      Inventory::Thing entry{std::move(title.name), std::move(title.place), uint32_t(end - i), "", 0, {}};
      if (end - i > 1) {
        const Thing last = things[end - 1];
        entry.last = last.type->title(last, section, scene).name;
        Hasher h;
        for (size_t k = i; k < end; ++k) h.digest(digestOf(things[k], digests[k]));
        entry.digest = h.result().low;
      } else {
        entry.digest = digestOf(t, digests[i]).low;
        if (t.type->parts && partsLeft > 0) {
          PartLister lister(digester, entry.parts);
          t.type->parts(lister, t);
          if (entry.parts.size() > partsLeft) entry.parts.clear(), partsLeft = 0;
          partsLeft -= entry.parts.size();
        }
      }
      inventory.things.push_back(std::move(entry));
    }
  }
  return inventory;
}

namespace {

// All nodes of a description, those that things share once for things that follow each other.
class NodeFinder {
 public:
  explicit NodeFinder(std::set<std::string>& names) : names_(names) {}
  template <class T>
  void look(const T& value) {
    if constexpr (std::is_same_v<T, Node>) {
      names_.insert(value.plugin);
    } else if constexpr (std::is_same_v<T, Shape> || std::is_same_v<T, ParameterList> ||
                         std::is_same_v<T, Transform>) {
      // these hold none
    } else if constexpr (Described<T>) {
      forEachField(value, [&](const auto&, const auto& member) { look(member); });
    } else if constexpr (IsVector<T>::value) {
      if constexpr (mayHold<typename T::value_type>())
        for (const auto& one : value) look(one);
    } else if constexpr (IsShared<T>::value) {
      using Plain = std::remove_const_t<typename T::element_type>;
      if constexpr (std::is_same_v<Plain, Attributes>) {
        if (!value || value.get() == last_) return;
        last_ = value.get();
        look(*value);
      } else if constexpr (std::is_same_v<Plain, Network>) {
        if (value && seen_.insert(value.get()).second) look(*value);
      } else if constexpr (Described<Plain>) {
        if (value) look(*value);
      }
    } else if constexpr (detail::IsOptional<T>::value) {
      if constexpr (Described<typename T::value_type>)
        if (value) look(*value);
    }
  }

 private:
  template <class T>
  static constexpr bool mayHold() {
    return Described<T> || IsShared<T>::value;
  }
  std::set<std::string>& names_;
  const void* last_ = nullptr;
  std::set<const void*> seen_;
};

}  // namespace

std::set<std::string> pluginsOf(const Scene& scene) {
  std::set<std::string> names{scene.pixelFilter};
  NodeFinder(names).look(scene);
  return names;
}

namespace {

std::string shown(const Inventory::Thing& t, const std::string& otherPlace = {}) {
  std::string s = t.name;
  if (t.count > 1) s = "one of " + std::to_string(t.count) + " things from " + t.name + " to " + t.last;
  if (!t.place.empty())
    s += " (" + t.place + (otherPlace.empty() || otherPlace == t.place ? "" : ", " + otherPlace) + ")";
  return s;
}

// The first index at which two lists are not alike, with which of them has something there that the other lacks.
enum class Lacks { Neither, First, Second };
template <class List, class Same, class Name>
std::pair<size_t, Lacks> firstUnlike(const List& a, const List& b, const Same& same, const Name& name) {
  size_t i = 0;
  while (i < a.size() && i < b.size() && same(a[i], b[i])) ++i;
  if (i == a.size()) return {i, i == b.size() ? Lacks::Neither : Lacks::First};
  if (i == b.size()) return {i, Lacks::Second};
  // Of one name they are the same thing, told otherwise, unless what stands here in one comes later in the other.
  const auto comesLater = [&](const auto& one, const List& in) {
    return std::any_of(in.begin() + ptrdiff_t(i) + 1, in.end(), [&](const auto& o) { return same(one, o); });
  };
  if (a.size() != b.size() || name(a[i]) != name(b[i])) {
    const bool isInSecond = comesLater(a[i], b), isInFirst = comesLater(b[i], a);
    if (isInSecond && (!isInFirst || a.size() < b.size())) return {i, Lacks::First};
    if (isInFirst && (!isInSecond || b.size() < a.size())) return {i, Lacks::Second};
  }
  return {i, Lacks::Neither};
}

}  // namespace

std::string firstDifference(const Inventory& first, const Inventory& second, std::string_view nameOfFirst,
                            std::string_view nameOfSecond) {
  const auto only = [](std::string_view which) { return " is in " + std::string(which) + " only"; };
  const auto &a = first.things, &b = second.things;
  const auto [i, lacks] = firstUnlike(
      a, b, [](const auto& x, const auto& y) { return x.digest == y.digest && x.count == y.count; },
      [](const auto& x) -> const std::string& { return x.name; });
  if (lacks == Lacks::First) return shown(b[i]) + only(nameOfSecond);
  if (lacks == Lacks::Second) return shown(a[i]) + only(nameOfFirst);
  if (i == a.size()) return "";
  const Inventory::Thing &x = a[i], &y = b[i];
  if (x.name != y.name) return shown(x) + " stands where " + std::string(nameOfSecond) + " has " + shown(y);
  const auto [k, lacksPart] = firstUnlike(
      x.parts, y.parts, [](const auto& p, const auto& q) { return p == q; },
      [](const auto& p) -> const std::string& { return p.name; });
  const std::string who = shown(x, y.place);
  if (x.parts.empty() || y.parts.empty() || (k == x.parts.size() && k == y.parts.size())) return who + " differs";
  const std::string& part = lacksPart == Lacks::First ? y.parts[k].name : x.parts[k].name;
  return who + " differs in " + part;
}

}  // namespace kinora::scene
