// SPDX-License-Identifier: MIT

#include "libshape/embedding/multiscale/multiscale_hierarchy.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <bit>
#include <limits>
#include <span>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

constexpr int centring_steps = 2;   // of Lloyd's relaxation; more make no better patches
constexpr int subtree_faces = 1500; // positions of a subtree fit a processor's second-level cache

using ChildSet = std::uint32_t; // bit k: in child k
static_assert(max_patches <= 32);

/// What a split needs to know of a face, by rows of its patch.
struct LocalFace
{
    std::array<int, 3> vertices;
    std::array<int, 3> edges;      ///< Edge c runs from vertex c to vertex c + 1.
    std::array<int, 3> neighbours; ///< Across edge c; -1 if none in the patch.
};

/// Nodes and, beside their faces, what is needed only while splitting.
struct Tree
{
    MultiscaleHierarchy hierarchy;
    std::vector<LocalFace> local_faces;
};

template <class Visit>
void for_each_bit(ChildSet set, const Visit& visit)
{
    for (; set != 0; set &= set - 1)
        visit(std::countr_zero(set));
}

/// Grows a tree from one patch. Its arrays are kept from node to node.
class Splitter
{
public:
    Splitter(Tree& tree, const Points& centroids, int children, std::uint64_t seed)
        : tree_(tree), centroids_(centroids), children_(children), random_(seed)
    {
    }

    /// Splits all patches of more than `limit` faces, breadth first; those of less than m triangles
    /// become leaves.
    void run(int limit)
    {
        for (int i = 0; i < static_cast<int>(tree_.hierarchy.nodes.size()); ++i) {
            const int faces = node(i).faces.count;
            if (faces >= children_ && faces > limit && split(i))
                continue;
            if (limit == 0)
                plan_gluing(i);
        }
    }

private:
    PatchNode& node(int i) { return tree_.hierarchy.nodes[to_size(i)]; }
    LocalFace* local_faces(int i) { return tree_.local_faces.data() + node(i).faces.begin; }

    bool split(int parent);
    void choose_seeds(int faces);
    void grow(int parent);
    void centre_seeds(int parent);
    void mark(int parent);
    void order_children(int parent);
    void emit_faces(int parent);
    void emit_vertices(int parent);
    void emit_edges(int parent);
    void emit_overlaps(int parent);
    void plan_gluing(int leaf);

    Tree& tree_;
    const Points& centroids_;
    const int children_;
    Random random_;

    std::vector<int> seeds_;
    std::vector<int> core_;         ///< Region of each face.
    std::vector<int> queue_;        ///< Faces in the order of growth.
    std::vector<double> distances_; ///< From each face to the middle of its region, squared.
    std::vector<ChildSet> in_faces_, in_vertices_, in_edges_;
    /// Rows in the children, at row * m + child.
    std::vector<int> face_rows_, vertex_rows_, edge_rows_;
    std::array<std::array<int, max_patches>, max_patches> shared_{}; ///< Counts of common vertices.
};

bool Splitter::split(int parent)
{
    choose_seeds(node(parent).faces.count);
    grow(parent);
    for (int step = 0; step < centring_steps; ++step) {
        centre_seeds(parent);
        grow(parent);
    }
    mark(parent);

    std::array<int, max_patches> sizes{};
    for (const ChildSet set : in_faces_)
        for_each_bit(set, [&](int k) { ++sizes[to_size(k)]; });
    if (*std::max_element(sizes.begin(), sizes.end()) == node(parent).faces.count)
        return false;

    order_children(parent);
    const int first = static_cast<int>(tree_.hierarchy.nodes.size());
    node(parent).first_child = first;
    node(parent).child_count = children_;
    for (int k = 0; k < children_; ++k)
        tree_.hierarchy.nodes.push_back({.parent = parent});
    emit_vertices(parent);
    emit_edges(parent);
    emit_faces(parent);
    emit_overlaps(parent);
    return true;
}

void Splitter::choose_seeds(int faces)
{
    seeds_.clear();
    while (static_cast<int>(seeds_.size()) < children_) {
        const int face = static_cast<int>(random_.index(static_cast<std::uint64_t>(faces)));
        if (std::find(seeds_.begin(), seeds_.end(), face) == seeds_.end())
            seeds_.push_back(face);
    }
}

/// All regions grow together, one ring of faces after another.
void Splitter::grow(int parent)
{
    const LocalFace* faces = local_faces(parent);
    core_.assign(to_size(node(parent).faces.count), -1);
    queue_ = seeds_;
    for (int k = 0; k < children_; ++k)
        core_[to_size(seeds_[to_size(k)])] = k;
    for (std::size_t i = 0; i < queue_.size(); ++i)
        for (const int neighbour : faces[queue_[i]].neighbours)
            if (neighbour >= 0 && core_[to_size(neighbour)] < 0) {
                core_[to_size(neighbour)] = core_[to_size(queue_[i])];
                queue_.push_back(neighbour);
            }
}

/// Moves every seed to the face of its region nearest to the region's centroid.
void Splitter::centre_seeds(int parent)
{
    const int* faces = tree_.hierarchy.faces.data() + node(parent).faces.begin;
    const int count = node(parent).faces.count;
    std::array<Eigen::Vector4d, max_patches> sums; // then the middles
    sums.fill(Eigen::Vector4d::Zero());
    for (int f = 0; f < count; ++f)
        sums[to_size(core_[to_size(f)])] += Eigen::Vector4d(
            centroids_(faces[f], 0), centroids_(faces[f], 1), centroids_(faces[f], 2), 1.0);
    for (Eigen::Vector4d& sum : sums)
        sum.head<3>() /= sum[3];
    std::array<double, max_patches> nearest, farthest;
    nearest.fill(std::numeric_limits<double>::infinity());
    farthest.fill(0.0);
    distances_.resize(to_size(count));
    for (int f = 0; f < count; ++f) {
        const std::size_t k = to_size(core_[to_size(f)]);
        const double distance =
            (centroids_.row(faces[f]).transpose() - sums[k].head<3>()).squaredNorm();
        distances_[to_size(f)] = distance;
        nearest[k] = std::min(nearest[k], distance);
        farthest[k] = std::max(farthest[k], distance);
    }
    // Of faces as near as rounding can tell, the last: a rigid motion must not change the choice.
    for (int f = 0; f < count; ++f) {
        const std::size_t k = to_size(core_[to_size(f)]);
        if (distances_[to_size(f)] <= nearest[k] + 1e-9 * farthest[k])
            seeds_[k] = f;
    }
}

/// Marks whatever each child holds: its core and the triangles it takes from its neighbours.
void Splitter::mark(int parent)
{
    const PatchNode& patch = node(parent);
    const LocalFace* faces = local_faces(parent);
    in_faces_.assign(to_size(patch.faces.count), 0);
    for (const int f : queue_) {
        const ChildSet own = ChildSet{1} << core_[to_size(f)];
        for (const int neighbour : faces[f].neighbours)
            // Bit `own` of a face that has been visited tells that this edge has been, too.
            if (neighbour >= 0 && core_[to_size(neighbour)] != core_[to_size(f)] &&
                (in_faces_[to_size(neighbour)] & (ChildSet{1} << core_[to_size(neighbour)])) == 0)
                in_faces_[to_size(neighbour)] |= own;
        in_faces_[to_size(f)] |= own;
    }
    in_vertices_.assign(to_size(patch.vertices.count), 0);
    in_edges_.assign(to_size(patch.edges.count), 0);
    for (int f = 0; f < patch.faces.count; ++f)
        for (std::size_t c = 0; c < 3; ++c) {
            in_vertices_[to_size(faces[f].vertices[c])] |= in_faces_[to_size(f)];
            in_edges_[to_size(faces[f].edges[c])] |= in_faces_[to_size(f)];
        }
}

/// Renumbers the children so that each has the largest overlap with one of those before it; the
/// first has most common vertices of all.
void Splitter::order_children(int parent)
{
    for (auto& row : shared_)
        row.fill(0);
    for (int v = 0; v < node(parent).vertices.count; ++v) {
        const ChildSet set = in_vertices_[to_size(v)];
        if (std::has_single_bit(set))
            continue;
        for_each_bit(set, [&](int k) {
            for_each_bit(set, [&](int l) { ++shared_[to_size(k)][to_size(l)]; });
        });
    }
    for (std::size_t k = 0; k < max_patches; ++k)
        shared_[k][k] = 0;

    std::array<int, max_patches> score{}, place{};
    place.fill(-1);
    for (std::size_t k = 0; k < to_size(children_); ++k)
        for (std::size_t l = 0; l < to_size(children_); ++l)
            score[k] += shared_[k][l];
    for (int placed = 0; placed < children_; ++placed) {
        int best = -1;
        for (int k = 0; k < children_; ++k)
            if (place[to_size(k)] < 0 && (best < 0 || score[to_size(k)] > score[to_size(best)]))
                best = k;
        place[to_size(best)] = placed;
        if (placed == 0)
            score.fill(0);
        for (std::size_t l = 0; l < to_size(children_); ++l)
            score[l] = std::max(score[l], shared_[to_size(best)][l]);
    }

    const auto renumber = [&](std::vector<ChildSet>& sets) {
        for (ChildSet& set : sets) {
            ChildSet renumbered = 0;
            for_each_bit(set, [&](int k) { renumbered |= ChildSet{1} << place[to_size(k)]; });
            set = renumbered;
        }
    };
    renumber(in_faces_);
    renumber(in_vertices_);
    renumber(in_edges_);
    const auto old = shared_;
    for (std::size_t k = 0; k < to_size(children_); ++k)
        for (std::size_t l = 0; l < to_size(children_); ++l)
            shared_[to_size(place[k])][to_size(place[l])] = old[k][l];
}

/// Gives each child a slice of an array, at its end, for what `sets` assign to it; fills `rows`.
/// @return the array's new size.
std::size_t lay_out(const std::vector<ChildSet>& sets, std::span<PatchNode> children,
                    Slice PatchNode::*slice, std::size_t end, std::vector<int>& rows)
{
    const std::size_t m = children.size();
    rows.resize(sets.size() * m);
    std::array<int, max_patches> counts{};
    for (std::size_t i = 0; i < sets.size(); ++i)
        for_each_bit(sets[i], [&](int k) { rows[i * m + to_size(k)] = counts[to_size(k)]++; });
    for (std::size_t k = 0; k < m; ++k) {
        children[k].*slice = {end, counts[k]};
        end += to_size(counts[k]);
    }
    return end;
}

void Splitter::emit_vertices(int parent)
{
    MultiscaleHierarchy& h = tree_.hierarchy;
    const std::span<PatchNode> children(h.nodes.data() + node(parent).first_child,
                                        to_size(children_));
    const std::size_t size =
        lay_out(in_vertices_, children, &PatchNode::vertices, h.vertices.size(), vertex_rows_);
    h.vertices.resize(size);
    h.in_parent.resize(size);
    for (int v = 0; v < node(parent).vertices.count; ++v)
        for_each_bit(in_vertices_[to_size(v)], [&](int k) {
            const std::size_t row = children[to_size(k)].vertices.begin +
                                    to_size(vertex_rows_[to_size(v * children_ + k)]);
            h.vertices[row] = h.vertices[node(parent).vertices.begin + to_size(v)];
            h.in_parent[row] = v;
        });
}

void Splitter::emit_edges(int parent)
{
    MultiscaleHierarchy& h = tree_.hierarchy;
    const std::span<PatchNode> children(h.nodes.data() + node(parent).first_child,
                                        to_size(children_));
    h.edges.resize(lay_out(in_edges_, children, &PatchNode::edges, h.edges.size(), edge_rows_));
    for (int e = 0; e < node(parent).edges.count; ++e) {
        PatchEdge& edge = h.edges[node(parent).edges.begin + to_size(e)];
        edge.copies = std::popcount(in_edges_[to_size(e)]);
        for_each_bit(in_edges_[to_size(e)], [&](int k) {
            h.edges[children[to_size(k)].edges.begin +
                    to_size(edge_rows_[to_size(e * children_ + k)])] = {
                vertex_rows_[to_size(edge.lower * children_ + k)],
                vertex_rows_[to_size(edge.upper * children_ + k)], edge.edge, 0};
        });
    }
}

void Splitter::emit_faces(int parent)
{
    MultiscaleHierarchy& h = tree_.hierarchy;
    const std::span<PatchNode> children(h.nodes.data() + node(parent).first_child,
                                        to_size(children_));
    const std::size_t size =
        lay_out(in_faces_, children, &PatchNode::faces, h.faces.size(), face_rows_);
    h.faces.resize(size);
    tree_.local_faces.resize(size);
    for (int f = 0; f < node(parent).faces.count; ++f)
        for_each_bit(in_faces_[to_size(f)], [&](int k) {
            const std::size_t row =
                children[to_size(k)].faces.begin + to_size(face_rows_[to_size(f * children_ + k)]);
            h.faces[row] = h.faces[node(parent).faces.begin + to_size(f)];
            const LocalFace& face = local_faces(parent)[f];
            LocalFace& copy = tree_.local_faces[row];
            for (std::size_t c = 0; c < 3; ++c) {
                const int neighbour = face.neighbours[c];
                copy.vertices[c] = vertex_rows_[to_size(face.vertices[c] * children_ + k)];
                copy.edges[c] = edge_rows_[to_size(face.edges[c] * children_ + k)];
                copy.neighbours[c] =
                    neighbour >= 0 && (in_faces_[to_size(neighbour)] >> k & 1U) != 0
                        ? face_rows_[to_size(neighbour * children_ + k)]
                        : -1;
            }
        });
}

void Splitter::emit_overlaps(int parent)
{
    MultiscaleHierarchy& h = tree_.hierarchy;
    Slice& slice = node(parent).overlaps;
    slice.begin = h.overlaps.size();
    std::array<std::array<std::size_t, max_patches>, max_patches> cursor;
    std::size_t end = h.common.size();
    for (int k = 0; k < children_; ++k)
        for (int l = k + 1; l < children_; ++l) {
            const int count = shared_[to_size(k)][to_size(l)];
            if (count == 0)
                continue;
            h.overlaps.push_back({k, l, end, count});
            cursor[to_size(k)][to_size(l)] = end;
            end += to_size(count);
        }
    slice.count = static_cast<int>(h.overlaps.size() - slice.begin);
    h.common.resize(end);
    for (int v = 0; v < node(parent).vertices.count; ++v)
        for_each_bit(in_vertices_[to_size(v)], [&](int k) {
            const ChildSet later = in_vertices_[to_size(v)] & ~((ChildSet{2} << k) - 1);
            for_each_bit(later, [&](int l) {
                h.common[cursor[to_size(k)][to_size(l)]++] = {
                    vertex_rows_[to_size(v * children_ + k)],
                    vertex_rows_[to_size(v * children_ + l)]};
            });
        });
}

/// Breadth first from the leaf's first face; a triangle without a new vertex adds nothing.
void Splitter::plan_gluing(int leaf)
{
    MultiscaleHierarchy& h = tree_.hierarchy;
    PatchNode& patch = node(leaf);
    const LocalFace* faces = local_faces(leaf);
    const auto edge = [&](int local) { return h.edges[patch.edges.begin + to_size(local)].edge; };
    patch.gluing.begin = h.gluing.size();
    std::vector<ChildSet>& reached = in_faces_; // workspaces of split(), idle here
    std::vector<ChildSet>& placed = in_vertices_;
    reached.assign(to_size(patch.faces.count), 0);
    placed.assign(to_size(patch.vertices.count), 0);

    const LocalFace& start = faces[0];
    h.gluing.push_back({{start.vertices[0], start.vertices[1], start.vertices[2], -1},
                        {edge(start.edges[0]), edge(start.edges[2]), edge(start.edges[1])}});
    reached[0] = 1;
    for (const int v : start.vertices)
        placed[to_size(v)] = 1;
    queue_.assign(1, 0);
    for (std::size_t i = 0; i < queue_.size(); ++i) {
        const LocalFace& face = faces[queue_[i]];
        for (std::size_t c = 0; c < 3; ++c) {
            if (face.neighbours[c] < 0 || reached[to_size(face.neighbours[c])] != 0)
                continue;
            reached[to_size(face.neighbours[c])] = 1;
            queue_.push_back(face.neighbours[c]);
            const LocalFace& next = faces[face.neighbours[c]];
            const auto d = to_size(std::find(next.edges.begin(), next.edges.end(), face.edges[c]) -
                                   next.edges.begin());
            const int apex = next.vertices[(d + 2) % 3];
            if (placed[to_size(apex)] != 0)
                continue;
            placed[to_size(apex)] = 1;
            h.gluing.push_back(
                {{face.vertices[c], face.vertices[(c + 1) % 3], face.vertices[(c + 2) % 3], apex},
                 {edge(face.edges[c]), edge(next.edges[(d + 1) % 3]),
                  edge(next.edges[(d + 2) % 3])}});
        }
    }
    patch.gluing.count = static_cast<int>(h.gluing.size() - patch.gluing.begin);
}

/// An order of elimination with little fill for the whole mesh. Restricted to a patch it has no
/// more fill than here, so it serves all of them.
std::vector<int> elimination_order(const Topology& topology)
{
    using Pattern = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(to_size(topology.edge_count() + topology.vertex_count()));
    for (int v = 0; v < topology.vertex_count(); ++v)
        entries.emplace_back(v, v, 1.0);
    for (int e = 0; e < topology.edge_count(); ++e)
        entries.emplace_back(topology.edges()(e, 1), topology.edges()(e, 0), 1.0);
    Pattern pattern(topology.vertex_count(), topology.vertex_count());
    pattern.setFromTriplets(entries.begin(), entries.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), order);
    return {order.indices().data(), order.indices().data() + order.indices().size()};
}

/// The whole mesh as one patch.
Tree whole_mesh(const Topology& topology)
{
    Tree tree;
    MultiscaleHierarchy& h = tree.hierarchy;
    h.vertices = elimination_order(topology);
    h.in_parent.assign(h.vertices.size(), 0);
    std::vector<int> row(h.vertices.size());
    for (int i = 0; i < topology.vertex_count(); ++i)
        row[to_size(h.vertices[to_size(i)])] = i;
    h.edges.resize(to_size(topology.edge_count()));
    for (int e = 0; e < topology.edge_count(); ++e) {
        const auto [lower, upper] =
            std::minmax(row[to_size(topology.edges()(e, 0))], row[to_size(topology.edges()(e, 1))]);
        h.edges[to_size(e)] = {lower, upper, e, 0};
    }
    h.faces.resize(to_size(topology.face_count()));
    tree.local_faces.resize(h.faces.size());
    for (int f = 0; f < topology.face_count(); ++f) {
        h.faces[to_size(f)] = f;
        for (int c = 0; c < 3; ++c) {
            const int opposite = topology.opposite(3 * f + c);
            tree.local_faces[to_size(f)].vertices[to_size(c)] =
                row[to_size(topology.faces()(f, c))];
            tree.local_faces[to_size(f)].edges[to_size(c)] = topology.face_edges()(f, c);
            tree.local_faces[to_size(f)].neighbours[to_size(c)] =
                opposite < 0 ? -1 : Topology::face(opposite);
        }
    }
    h.nodes.push_back({.faces = {0, topology.face_count()},
                       .vertices = {0, topology.vertex_count()},
                       .edges = {0, topology.edge_count()}});
    return tree;
}

template <class Value>
std::vector<Value> copy_slice(const std::vector<Value>& values, Slice slice)
{
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(slice.begin);
    return {begin, begin + slice.count};
}

/// One patch of a tree as a tree of its own.
Tree cut_out(const Tree& tree, const PatchNode& patch)
{
    Tree cut;
    cut.hierarchy.faces = copy_slice(tree.hierarchy.faces, patch.faces);
    cut.hierarchy.vertices = copy_slice(tree.hierarchy.vertices, patch.vertices);
    cut.hierarchy.in_parent = copy_slice(tree.hierarchy.in_parent, patch.vertices);
    cut.hierarchy.edges = copy_slice(tree.hierarchy.edges, patch.edges);
    cut.local_faces = copy_slice(tree.local_faces, patch.faces);
    cut.hierarchy.nodes.push_back({.faces = {0, patch.faces.count},
                                   .vertices = {0, patch.vertices.count},
                                   .edges = {0, patch.edges.count}});
    return cut;
}

/// Appends values from `skip` on; @return what to add to an index into `source`.
template <class Value>
std::size_t append(std::vector<Value>& target, const std::vector<Value>& source, int skip)
{
    const std::size_t shift = target.size() - to_size(skip);
    target.insert(target.end(), source.begin() + skip, source.end());
    return shift;
}

/// Appends all nodes below the root of `part`, which is node `root` of `whole`.
void graft(MultiscaleHierarchy& whole, int root, const MultiscaleHierarchy& part)
{
    const PatchNode& old_root = part.nodes[0];
    PatchNode& new_root = whole.nodes[to_size(root)];
    for (int e = 0; e < old_root.edges.count; ++e)
        whole.edges[new_root.edges.begin + to_size(e)].copies = part.edges[to_size(e)].copies;
    const std::size_t faces = append(whole.faces, part.faces, old_root.faces.count);
    const std::size_t vertices = append(whole.vertices, part.vertices, old_root.vertices.count);
    append(whole.in_parent, part.in_parent, old_root.vertices.count);
    const std::size_t edges = append(whole.edges, part.edges, old_root.edges.count);
    const std::size_t overlaps = append(whole.overlaps, part.overlaps, 0);
    const std::size_t common = append(whole.common, part.common, 0);
    const std::size_t gluing = append(whole.gluing, part.gluing, 0);
    for (std::size_t i = overlaps; i < whole.overlaps.size(); ++i)
        whole.overlaps[i].begin += common;

    const int shift = static_cast<int>(whole.nodes.size()) - 1;
    new_root.first_child = old_root.first_child + shift;
    new_root.child_count = old_root.child_count;
    new_root.overlaps = {old_root.overlaps.begin + overlaps, old_root.overlaps.count};
    new_root.gluing = {old_root.gluing.begin + gluing, old_root.gluing.count};
    for (std::size_t i = 1; i < part.nodes.size(); ++i) {
        PatchNode node = part.nodes[i];
        node.parent = node.parent == 0 ? root : node.parent + shift;
        node.first_child += shift;
        node.faces.begin += faces;
        node.vertices.begin += vertices;
        node.edges.begin += edges;
        node.overlaps.begin += overlaps;
        node.gluing.begin += gluing;
        whole.nodes.push_back(node);
    }
    whole.subtrees.push_back({root, shift + 1, static_cast<int>(whole.nodes.size())});
}

} // namespace

void check(const HierarchyOptions& options)
{
    require(options.children >= 4 && options.children <= max_patches, "HierarchyOptions.children",
            options.children, join("in [4, ", max_patches, "]"));
}

MultiscaleHierarchy build_hierarchy(const Topology& topology, const Points& points,
                                    const HierarchyOptions& options)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, the topology ",
                                topology.vertex_count(), " vertices"));
    check(options);
    Points centroids(topology.face_count(), 3);
    for (int f = 0; f < topology.face_count(); ++f)
        centroids.row(f) =
            (points.row(topology.faces()(f, 0)) + points.row(topology.faces()(f, 1)) +
             points.row(topology.faces()(f, 2))) /
            3.0;

    Tree tree = whole_mesh(topology);
    Splitter(tree, centroids, options.children, options.seed).run(subtree_faces);
    MultiscaleHierarchy& whole = tree.hierarchy;
    whole.top = static_cast<int>(whole.nodes.size());

    std::vector<int> roots;
    for (int i = 0; i < whole.top; ++i)
        if (whole.nodes[to_size(i)].is_leaf())
            roots.push_back(i);
    std::vector<Tree> parts(roots.size());
    parallel_for(roots.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            parts[i] = cut_out(tree, whole.nodes[to_size(roots[i])]);
            Random seeds(options.seed + i + 1);
            Splitter(parts[i], centroids, options.children, seeds.bits()).run(0);
            parts[i].local_faces = {};
        }
    });
    const auto reserve = [&](auto member) {
        std::size_t size = (whole.*member).size();
        for (const Tree& part : parts)
            size += (part.hierarchy.*member).size();
        (whole.*member).reserve(size);
    };
    reserve(&MultiscaleHierarchy::nodes);
    reserve(&MultiscaleHierarchy::faces);
    reserve(&MultiscaleHierarchy::vertices);
    reserve(&MultiscaleHierarchy::in_parent);
    reserve(&MultiscaleHierarchy::edges);
    reserve(&MultiscaleHierarchy::overlaps);
    reserve(&MultiscaleHierarchy::common);
    reserve(&MultiscaleHierarchy::gluing);
    for (std::size_t i = 0; i < roots.size(); ++i) {
        graft(whole, roots[i], parts[i].hierarchy);
        parts[i] = {};
    }
    return std::move(tree.hierarchy);
}

} // namespace shape::internal
