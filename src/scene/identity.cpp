#include "scene/identity.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <set>

#include "scene/fields.h"

namespace kinora::scene {

bool optionDecidesPixels(const Parameter& option) {
  static constexpr std::string_view kGroups[] = {"searchpath:", "statistics:", "ribparse:", "rib:", "bucket:"};
  static constexpr std::string_view kNames[] = {"limits:bucketsize", "limits:threads", "limits:texturememory",
                                                "limits:geocachememory", "shader:cache"};
  const std::string_view name = option.name;
  return std::none_of(std::begin(kGroups), std::end(kGroups),
                      [&](std::string_view group) { return name.starts_with(group); }) &&
         std::find(std::begin(kNames), std::end(kNames), name) == std::end(kNames);
}

namespace {

template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsArray : std::false_type {};
template <class T, size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};
template <class T>
struct IsShared : std::false_type {};
template <class T>
struct IsShared<std::shared_ptr<T>> : std::true_type {};
template <class T>
struct IsMap : std::false_type {};
template <class T>
struct IsMap<std::map<std::string, T>> : std::true_type {};
template <class T>
constexpr bool kIsNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;
// Values without padding and without owners: their bytes are what they say.
template <class T>
constexpr bool kIsBytes = (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_same_v<T, Matrix>;

// Where in the scene the things are that others name by their id. Only light sources are named so: objects list those
// that shine on them, and an area light is an object as well.
class Places {
 public:
  explicit Places(const Scene& scene) {
    if (scene.classicLights.empty()) return;
    for (size_t i = 0; i < scene.classicLights.size(); ++i)
      places_.try_emplace(scene.classicLights[i].id, uint64_t(i) << 1 | 1);
    for (size_t i = 0; i < scene.primitives.size(); ++i)
      places_.try_emplace(scene.primitives[i]->id, uint64_t(i) << 1);
  }
  uint64_t of(uint32_t id) const {
    const auto it = places_.find(id);
    return it == places_.end() ? ~uint64_t(id) : it->second;
  }

 private:
  std::unordered_map<uint32_t, uint64_t> places_;
};

// What digests depend on beside the thing itself.
struct Surroundings {
  const Scene& scene;
  const ContentsByName& files;
  Places places;
};

// Digests of things. It remembers those of what things share, so that each is worked out once; one for each thread.
class Digester {
 public:
  explicit Digester(const Surroundings& s) : s_(s) {}

  template <class T>
  Digest of(const T& value) {
    Hasher h;
    add(h, value);
    return h.result();
  }
  template <class F>
  Digest of(const F& field, const typename F::Member& value) {
    Hasher h;
    add(h, field, value);
    return h.result();
  }

 private:
  template <class F>
  void add(Hasher& h, const F& field, const typename F::Member& value) {
    if constexpr (F::kCounts == Counts::ByPlace)
      addPlaces(h, value);
    else if constexpr (std::is_same_v<typename F::Member, ParameterList>)
      addParameters(h, value, field.isCounted);
    else if constexpr (F::kCounts == Counts::Always)
      add(h, value);
  }

  void addPlaces(Hasher& h, const std::shared_ptr<const std::vector<uint32_t>>& ids) {
    h.word(ids ? ids->size() + 1 : 0);
    if (ids)
      for (const uint32_t id : *ids) h.word(s_.places.of(id));
  }

  // What parameters say may be names of files.
  void addArgument(Hasher& h, const std::string& text) {
    const auto file = s_.files.find(text);
    h.word(file != s_.files.end());
    file != s_.files.end() ? h.digest(file->second) : h.text(text);
  }

  void addParameters(Hasher& h, const ParameterList& list, bool (*isCounted)(const Parameter&)) {
    uint64_t count = 0;
    for (const Parameter& p : list)
      if (!isCounted || isCounted(p)) add(h, p), ++count;
    h.word(count);
  }

  // Shared by many owners: once.
  template <class T>
  void addShared(Hasher& h, const std::shared_ptr<T>& pointer) {
    using Plain = std::remove_const_t<T>;
    h.word(pointer != nullptr);
    if (!pointer) return;
    if constexpr (std::is_same_v<Plain, Attributes>) {
      // mostly those of the object before
      if (pointer.get() != lastAttributes_) {
        digestOfLast_ = of(*pointer);
        lastAttributes_ = pointer.get();
      }
      h.digest(digestOfLast_);
    } else if constexpr (std::is_same_v<Plain, Network> || IsMap<Plain>::value) {
      auto it = known_.find(pointer.get());
      if (it == known_.end()) it = known_.emplace(pointer.get(), of(*pointer)).first;
      h.digest(it->second);
    } else {
      add(h, *pointer);
    }
  }

  template <class T>
  void add(Hasher& h, const T& value) {
    if constexpr (std::is_same_v<T, float>) {
      h.word(std::bit_cast<uint32_t>(value));
    } else if constexpr (std::is_same_v<T, double>) {
      h.word(std::bit_cast<uint64_t>(value));
    } else if constexpr (kIsNumber<T>) {
      h.word(uint64_t(value));
    } else if constexpr (std::is_same_v<T, Matrix>) {
      h.bytes(&value, sizeof value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      h.text(value);
    } else if constexpr (std::is_same_v<T, ParameterList>) {
      addParameters(h, value, nullptr);
    } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
      h.word(value.size());
      for (const std::string& one : value) addArgument(h, one);
    } else if constexpr (IsVector<T>::value || IsArray<T>::value) {
      if constexpr (kIsBytes<typename T::value_type>) {
        h.bytes(value.data(), value.size() * sizeof(typename T::value_type));
      } else {
        h.word(value.size());
        for (const auto& one : value) add(h, one);
      }
    } else if constexpr (IsMap<T>::value) {
      h.word(value.size());
      for (const auto& [name, one] : value) h.text(name), add(h, one);
    } else if constexpr (IsShared<T>::value) {
      addShared(h, value);
    } else if constexpr (detail::IsOptional<T>::value) {
      h.word(value.has_value());
      if (value) add(h, *value);
    } else if constexpr (std::is_same_v<T, Shape>) {
      h.word(value.index());
      std::visit([&](const auto& shape) { add(h, shape); }, value);
    } else {
      forEachField(value, [&](const auto& field, const auto& member) { add(h, field, member); });
      // which object the light is as well, and so does not stand in the scene a second time
      if constexpr (std::is_same_v<T, Light>)
        if (value.geometry) h.word(s_.places.of(value.geometry->id));
    }
  }

  const Surroundings& s_;
  const void* lastAttributes_ = nullptr;
  Digest digestOfLast_;
  std::unordered_map<const void*, Digest> known_;
};

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
      for (const Parameter& p : value.params) put(inQuotes(before + "parameter", p.name), digester_.of(p));
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
  Digest (*digest)(Digester&, const void*);
  Title (*title)(const Thing&, const Section&, const Scene&);
  void (*parts)(PartLister&, const void*);  // null: it has none
};
struct Thing {
  const void* object;
  const ThingType* type;
  const std::string* key;  // in its section, or the object that it stands in; null: none
};

// All things of a scene in the order of its fields; a section for each field.
class Things {
 public:
  explicit Things(const Scene& scene) {
    forEachField(scene, [&]<class F>(const F& field, const typename F::Member& member) {
      if constexpr (F::kCounts != Counts::Never) {
        const size_t first = list.size();
        add(field, member);
        sections.push_back({field.name, first, list.size()});
      }
    });
  }
  std::vector<Thing> list;
  std::vector<Section> sections;

 private:
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
    static constexpr ThingType kType{// itself: what stands in it are things of their own
                                     [](Digester& digester, const void* object) {
                                       Hasher h;
                                       forEachField(*static_cast<const Prototype*>(object),
                                                    [&]<class F>(const F& field, const typename F::Member& member) {
                                                      if constexpr (IsVector<typename F::Member>::value)
                                                        h.word(member.size());
                                                      else
                                                        h.digest(digester.of(field, member));
                                                    });
                                       return h.result();
                                     },
                                     [](const Thing& t, const Section&, const Scene&) {
                                       const auto& o = *static_cast<const Prototype*>(t.object);
                                       return Title{inQuotes("ObjectBegin", o.name), placeOf(o.pos)};
                                     },
                                     nullptr};
    list.push_back({&p, &kType, nullptr});
    forEachField(p, [&](const auto&, const auto& member) {
      if constexpr (IsVector<std::decay_t<decltype(member)>>::value) addAll(member, &p.name);
    });
  }
  template <class T>
  void addThing(const T& object, const std::string* within = nullptr) {
    static constexpr ThingType kType{[](Digester& d, const void* o) { return d.of(*static_cast<const T*>(o)); },
                                     [](const Thing& t, const Section&, const Scene& s) {
                                       Title title = titleOf(*static_cast<const T*>(t.object), s);
                                       if (t.key) title.name += inQuotes(" of ObjectBegin", *t.key);
                                       return title;
                                     },
                                     [](PartLister& l, const void* o) { l.list(*static_cast<const T*>(o)); }};
    list.push_back({&object, &kType, within});
  }
  template <class T>
  void addPlain(const T& value, const std::string* key) {
    static constexpr ThingType kType{[](Digester& d, const void* o) { return d.of(*static_cast<const T*>(o)); },
                                     [](const Thing& t, const Section& section, const Scene&) {
                                       const std::string name(section.field);
                                       return Title{t.key ? inQuotes(name, *t.key) : name, ""};
                                     },
                                     nullptr};
    list.push_back({&value, &kType, key});
  }
};

// A key that a thing stands under counts as well.
Digest digestOf(const Thing& t, Digester& digester) {
  Hasher h;
  h.digest(t.type->digest(digester, t.object));
  if (t.key) h.text(*t.key);
  return h.result();
}

std::vector<Digest> digestsOf(const Things& things, const Surroundings& s) {
  constexpr size_t kChunk = 1024;
  std::vector<Digest> digests(things.list.size());
  tbb::parallel_for(size_t(0), (digests.size() + kChunk - 1) / kChunk, [&](size_t chunk) {
    Digester digester(s);
    for (size_t i = chunk * kChunk; i < std::min(digests.size(), (chunk + 1) * kChunk); ++i)
      digests[i] = digestOf(things.list[i], digester);
  });
  return digests;
}

}  // namespace

Digest digestOf(const Scene& scene, const ContentsByName& files) {
  const Surroundings s{scene, files, Places(scene)};
  const Things things(scene);
  const std::vector<Digest> digests = digestsOf(things, s);
  Hasher h;
  for (const Section& section : things.sections) {
    h.word(section.end - section.first);
    for (size_t i = section.first; i < section.end; ++i) h.digest(digests[i]);
  }
  return h.result();
}

Inventory inventoryOf(const Scene& scene, const ContentsByName& files, const InventorySize& most) {
  const Surroundings s{scene, files, Places(scene)};
  const Things things(scene);
  const std::vector<Digest> digests = digestsOf(things, s);
  Digester digester(s);
  Inventory inventory;
  for (const Section& section : things.sections) {
    const size_t all = section.end - section.first,
                 size = (all + most.entries - 1) / std::max<size_t>(1, most.entries);
    size_t partsLeft = most.parts;
    for (size_t i = section.first; i < section.end; i += size) {
      const size_t end = std::min(i + size, section.end);
      const Thing& t = things.list[i];
      Title title = t.type->title(t, section, scene);
      Inventory::Thing entry{std::move(title.name), std::move(title.place), uint32_t(end - i), "", 0, {}};
      if (end - i > 1) {
        entry.last = things.list[end - 1].type->title(things.list[end - 1], section, scene).name;
        Hasher h;
        for (size_t k = i; k < end; ++k) h.digest(digests[k]);
        entry.digest = h.result().low;
      } else {
        entry.digest = digests[i].low;
        if (t.type->parts && partsLeft > 0) {
          PartLister lister(digester, entry.parts);
          t.type->parts(lister, t.object);
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
