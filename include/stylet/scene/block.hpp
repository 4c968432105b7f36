// Blocks: codecs of structs, made of fields.
#pragma once

#include "stylet/scene/codec.hpp"

namespace stylet {

/// One key of a block. `write` gives none where there is nothing to write.
template <class Owner>
struct Field {
  Key key;
  std::function<void(const Node&, Owner&)> read;
  std::function<std::optional<Node>(const Owner&)> write;

  [[nodiscard]] Field required() const {
    Field field = *this;
    field.key.required = true;
    return field;
  }
  /// Says what holds without the key, where it is not the value of the struct.
  [[nodiscard]] Field otherwise(const std::string& fallback) const {
    Field field = *this;
    field.key.fallback = fallback;
    return field;
  }
  /// Another way to write a key of the block, into whose value it is turned: never written, and refused beside it.
  [[nodiscard]] Field spelling_of(const std::string& name) const {
    Field field = otherwise("not beside " + name);
    field.key.spells = name;
    field.write = [](const Owner&) { return std::nullopt; };
    return field;
  }
  /// Written only where the condition holds.
  template <class Condition>
  [[nodiscard]] Field written_if(Condition condition) const {
    Field field = *this;
    field.write = [condition, inner = write](const Owner& owner) {
      return condition(owner) ? inner(owner) : std::nullopt;
    };
    return field;
  }
};

[[nodiscard]] Key described(Key key, const std::string& name, const std::string& doc);

/// An empty text, list or map stands for a key that was not given.
[[nodiscard]] std::optional<Node> unless_empty(Node node);

template <class Owner, class T>
Field<Owner> field(const std::string& name,
                   T Owner::*member,
                   const Codec<T>& codec,
                   const std::string& doc) {
  return {
      described(codec.key, name, doc),
      [member, read = codec.read](const Node& node, Owner& owner) { read(node, owner.*member); },
      [member, write = codec.write](const Owner& owner) {
        return unless_empty(write(owner.*member));
      }};
}

template <class Owner, class T>
Field<Owner> field(const std::string& name,
                   std::optional<T> Owner::*member,
                   const Codec<T>& codec,
                   const std::string& doc) {
  return {described(codec.key, name, doc),
          [member, read = codec.read](const Node& node, Owner& owner) {
            read(node, (owner.*member).emplace());
          },
          [member, write = codec.write](const Owner& owner) {
            return owner.*member ? std::optional(write(*(owner.*member))) : std::nullopt;
          }};
}

/// A key that is one alternative of a variant.
template <class Owner, class Variant, class T>
Field<Owner> alternative(const std::string& name,
                         Variant Owner::*member,
                         const Codec<T>& codec,
                         const std::string& doc) {
  return {described(codec.key, name, doc),
          [member, read = codec.read](const Node& node, Owner& owner) {
            read(node, (owner.*member).template emplace<T>());
          },
          [member, write = codec.write](const Owner& owner) {
            const T* value = std::get_if<T>(&(owner.*member));
            return value ? unless_empty(write(*value)) : std::nullopt;
          }};
}

/// Two members under one key, [first, second].
template <class Owner>
Field<Owner> field(const std::string& name,
                   double Owner::*first,
                   double Owner::*second,
                   const Codec<std::pair<double, double>>& codec,
                   const std::string& doc) {
  return {described(codec.key, name, doc),
          [first, second, read = codec.read](const Node& node, Owner& owner) {
            std::pair<double, double> both;
            read(node, both);
            owner.*first = both.first;
            owner.*second = both.second;
          },
          [first, second, write = codec.write](const Owner& owner) {
            return std::optional(write({owner.*first, owner.*second}));
          }};
}

/// Three members under one key, [first, second, third].
template <class Owner>
Field<Owner> field(const std::string& name,
                   double Owner::*first,
                   double Owner::*second,
                   double Owner::*third,
                   const Codec<std::array<double, 3>>& codec,
                   const std::string& doc) {
  return {described(codec.key, name, doc),
          [=, read = codec.read](const Node& node, Owner& owner) {
            std::array<double, 3> values{};
            read(node, values);
            owner.*first = values[0];
            owner.*second = values[1];
            owner.*third = values[2];
          },
          [=, write = codec.write](const Owner& owner) {
            return std::optional(write({owner.*first, owner.*second, owner.*third}));
          }};
}

/// Keys of which a block has at most one, or exactly one if `needed`.
struct Exclusive {
  std::vector<std::string> names = {};
  bool needed = true;
};

/// Refuses everything but a map with known keys and all required ones, each spelt in one way.
void require_block(const Node& node, const Key& key);
void require_exclusive(const Node& node, const Exclusive& exclusive);

template <class T>
Codec<T> block_with_rules(const std::vector<Field<T>>& fields,
                          const std::vector<Exclusive>& exclusive) {
  Key key{.form = Key::Form::block, .type = "block"};
  std::vector<std::pair<std::string, decltype(Field<T>::read)>> readers;
  std::vector<std::pair<std::string, decltype(Field<T>::write)>> writers;
  for (const Field<T>& field : fields) {
    key.keys.push_back(field.key);
    readers.emplace_back(field.key.name, field.read);
    writers.emplace_back(field.key.name, field.write);
    Key& last = key.keys.back();
    if (last.form != Key::Form::value || last.required || !last.fallback.empty()) continue;
    const auto fallback = field.write(T{});
    last.fallback = fallback ? shown(*fallback) : "none";
  }
  return {key,
          [key, exclusive, readers](const Node& node, T& value) {
            require_block(node, key);
            for (const Exclusive& rule : exclusive) require_exclusive(node, rule);
            for (const auto& [name, read] : readers) {
              if (const Node* child = node.find(name)) read(*child, value);
            }
          },
          [writers](const T& value) {
            Node node = Node::map();
            for (const auto& [name, write] : writers) {
              if (auto child = write(value)) node.add(*std::move(child), name);
            }
            return node;
          }};
}

template <class T>
Codec<T> block(const std::vector<Field<T>>& fields, const Exclusive& exclusive = {}) {
  return block_with_rules<T>(fields, {exclusive});
}

/// A block without a struct of its own: its fields belong to the owner.
template <class Owner>
Field<Owner> group(const std::string& name,
                   const std::vector<Field<Owner>>& fields,
                   const std::string& doc) {
  const Codec<Owner> codec = block<Owner>(fields);
  return {described(codec.key, name, doc), codec.read,
          [write = codec.write](const Owner& owner) { return unless_empty(write(owner)); }};
}

}  // namespace stylet
