/* Triangles in a binary tree of boxes, halved at the median along the longest axis of their centres: not the
 * fastest tree, but one of logarithmic depth for any input.
 *
 * A ray is in a triangle if it is once both are seen along the ray, sheared to two dimensions (Woop, Benthin
 * and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013): there a corner is a function of the vertex
 * and the ray, and a difference of two products has no wrong sign, so no gap opens between neighbours. Where
 * the ray meets the plane is computed as shaders/mesh.frag.glsl computes it. */
#include "mesh_tree.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "scene.h"
#include "vector.h"

#define LEAF_TRIANGLES 4
#define MAX_DEPTH      64 /* 2^64 triangles */

struct ref {
    double centre[3];
    uint32_t mesh, triangle;
};

/* Children follow each other; a leaf has triangles instead. */
struct node {
    double low[3], high[3];
    uint64_t first; /* child, or ref */
    uint32_t count; /* triangles; 0: not a leaf */
};

struct vr_mesh_tree {
    const struct vr_mesh *meshes;
    struct ref *refs;
    uint64_t ref_count;
    struct node *nodes;
    uint64_t node_count;
};

static const double *corner_of(const struct vr_mesh_tree *tree, const struct ref *ref, int k)
{
    const struct brick_mesh *mesh = tree->meshes[ref->mesh].mesh;
    return mesh->position_mm[mesh->triangle[ref->triangle][k]];
}

static void fit_box(const struct vr_mesh_tree *tree, struct node *node, uint64_t first, uint64_t count)
{
    for (int i = 0; i < 3; i++) {
        node->low[i] = INFINITY;
        node->high[i] = -INFINITY;
        for (uint64_t r = first; r < first + count; r++)
            for (int k = 0; k < 3; k++) {
                double x = corner_of(tree, &tree->refs[r], k)[i];
                node->low[i] = fmin(node->low[i], x);
                node->high[i] = fmax(node->high[i], x);
            }
    }
}

/* [first, last] in two parts, neither empty, none of the first behind any of the second along the axis
 * (Hoare). Returns the first part's last. */
static uint64_t partition(struct ref *refs, uint64_t first, uint64_t last, uint64_t pivot, int axis)
{
    const struct ref middle = refs[pivot];
    uint64_t low = first, high = last;
    refs[pivot] = refs[first];
    refs[first] = middle;
    for (;; low++, high--) {
        while (refs[low].centre[axis] < middle.centre[axis])
            low++;
        while (refs[high].centre[axis] > middle.centre[axis])
            high--;
        if (low >= high)
            return high;
        const struct ref ref = refs[low];
        refs[low] = refs[high];
        refs[high] = ref;
    }
}

/* Put refs in an order in which none of the first `half` is behind any of the others: a random pivot, so no
 * mesh makes it slow. */
static void halve(struct ref *refs, uint64_t count, uint64_t half, int axis)
{
    uint64_t first = 0, last = count - 1, random = count;
    while (first < last) {
        random = random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        const uint64_t end = partition(refs, first, last, first + (random >> 32) % (last - first + 1), axis);
        if (half == end + 1)
            return;
        if (half <= end)
            last = end;
        else
            first = end + 1;
    }
}

static int longest_axis(const struct ref *refs, uint64_t count)
{
    double extent[3];
    for (int i = 0; i < 3; i++) {
        double low = INFINITY, high = -INFINITY;
        for (uint64_t r = 0; r < count; r++) {
            low = fmin(low, refs[r].centre[i]);
            high = fmax(high, refs[r].centre[i]);
        }
        extent[i] = high - low;
    }
    int axis = extent[1] > extent[0] ? 1 : 0;
    return extent[2] > extent[axis] ? 2 : axis;
}

/* The node is there, empty; its children come behind all nodes so far. */
static void build(struct vr_mesh_tree *tree, uint64_t at, uint64_t first, uint64_t count)
{
    struct node *node = &tree->nodes[at];
    fit_box(tree, node, first, count);
    if (count <= LEAF_TRIANGLES) {
        node->first = first;
        node->count = (uint32_t)count;
        return;
    }
    halve(tree->refs + first, count, count / 2, longest_axis(tree->refs + first, count));
    uint64_t child = node->first = tree->node_count;
    tree->node_count += 2;
    build(tree, child, first, count / 2);
    build(tree, child + 1, first + count / 2, count - count / 2);
}

static void list_triangles(struct vr_mesh_tree *tree, uint32_t count)
{
    uint64_t at = 0;
    for (uint32_t m = 0; m < count; m++)
        for (uint64_t t = 0; t < tree->meshes[m].mesh->triangles; t++, at++) {
            struct ref *ref = &tree->refs[at];
            *ref = (struct ref){.mesh = m, .triangle = (uint32_t)t};
            for (int k = 0; k < 3; k++)
                for (int i = 0; i < 3; i++)
                    ref->centre[i] += corner_of(tree, ref, k)[i] / 3.0;
        }
}

int vr_mesh_tree_create(struct vr_mesh_tree **out, const struct vr_mesh *meshes, uint32_t count,
                        struct brick_error *err)
{
    struct vr_mesh_tree *tree = *out = calloc(1, sizeof *tree);
    unsigned long long triangles = 0;
    for (uint32_t m = 0; m < count; m++)
        triangles += meshes[m].mesh->triangles;
    if (tree) {
        tree->meshes = meshes;
        tree->ref_count = triangles;
        /* A leaf has at least two triangles, or is the only one: so many nodes are never needed. */
        tree->refs = calloc(tree->ref_count, sizeof *tree->refs);
        tree->nodes = calloc(2 * tree->ref_count, sizeof *tree->nodes);
    }
    if (!tree || !tree->refs || !tree->nodes) {
        vr_mesh_tree_destroy(out);
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a tree of %llu triangles", triangles);
    }
    list_triangles(tree, count);
    tree->node_count = 1;
    build(tree, 0, 0, tree->ref_count);
    return BRICK_OK;
}

void vr_mesh_tree_destroy(struct vr_mesh_tree **tree)
{
    if (!*tree)
        return;
    free((*tree)->refs);
    free((*tree)->nodes);
    free(*tree);
    *tree = NULL;
}

/* Where the ray enters the box, or infinity; wider by more than its rounding. */
static double enter_box(const struct node *node, const struct brick_ray *ray, double t_max)
{
    double enter = 0.0, leave = t_max;
    for (int i = 0; i < 3; i++) {
        if (ray->direction[i] == 0.0) {
            if (ray->origin[i] < node->low[i] || ray->origin[i] > node->high[i])
                return INFINITY;
            continue;
        }
        double a = (node->low[i] - ray->origin[i]) / ray->direction[i];
        double b = (node->high[i] - ray->origin[i]) / ray->direction[i];
        enter = fmax(enter, fmin(a, b));
        leave = fmin(leave, fmax(a, b));
    }
    return enter <= leave + 1e-12 * (fabs(leave) + 1.0) ? enter : INFINITY;
}

/* Corners, seen from the ray's origin, along the ray. */
static void flatten(const double direction[3], double at[3][3], double flat[3][2])
{
    int z = fabs(direction[1]) > fabs(direction[0]) ? 1 : 0;
    if (fabs(direction[2]) > fabs(direction[z]))
        z = 2;
    for (int i = 0; i < 2; i++) {
        int axis = (z + 1 + i) % 3;
        double slope = direction[axis] / direction[z];
        for (int k = 0; k < 3; k++)
            flat[k][i] = at[k][axis] - slope * at[k][z];
    }
}

/* The weights of the triangle's second and third corner where the ray meets it before hit->t_mm. */
static bool meet(const struct vr_mesh_tree *tree, const struct ref *ref, const struct brick_ray *ray,
                 double *t_mm, double weight[2], double normal[3])
{
    double at[3][3], flat[3][2], to_b[3], to_c[3], p[3], side[3], n[3];
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            at[k][i] = corner_of(tree, ref, k)[i] - ray->origin[i];
    flatten(ray->direction, at, flat);
    for (int k = 0; k < 3; k++) {
        const double *q = flat[(k + 1) % 3], *r = flat[(k + 2) % 3];
        side[k] = q[0] * r[1] - q[1] * r[0];
    }
    if (!((side[0] >= 0.0 && side[1] >= 0.0 && side[2] >= 0.0) ||
          (side[0] <= 0.0 && side[1] <= 0.0 && side[2] <= 0.0)))
        return false;
    for (int i = 0; i < 3; i++) {
        to_b[i] = at[1][i] - at[0][i];
        to_c[i] = at[2][i] - at[0][i];
    }
    vr_cross(to_b, to_c, n);
    double along = vr_dot(n, ray->direction), area = vr_dot(n, n), t = vr_dot(n, at[0]) / along;
    if (along == 0.0 || !(area > 0.0) || !(t >= 0.0 && t < *t_mm))
        return false;
    for (int i = 0; i < 3; i++) {
        p[i] = t * ray->direction[i] - at[0][i];
        normal[i] = n[i];
    }
    *t_mm = t;
    vr_cross(p, to_c, side);
    weight[0] = vr_dot(side, n) / area;
    vr_cross(to_b, p, side);
    weight[1] = vr_dot(side, n) / area;
    return true;
}

static void look(const struct vr_mesh *mesh, const uint32_t corner[3], const double weight[2],
                 struct vr_mesh_hit *hit)
{
    const double w[3] = {1.0 - weight[0] - weight[1], weight[0], weight[1]};
    double normal[3] = {0}, rgb[3] = {0};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) {
            if (mesh->mesh->normal)
                normal[i] += w[k] * (double)mesh->mesh->normal[corner[k]][i];
            rgb[i] += w[k] * (mesh->mesh->colour ? (double)mesh->mesh->colour[corner[k]][i] : mesh->rgb[i]);
        }
    for (int i = 0; i < 3; i++) {
        hit->rgb[i] = rgb[i];
        if (normal[0] != 0.0 || normal[1] != 0.0 || normal[2] != 0.0)
            hit->normal[i] = normal[i];
    }
}

bool vr_mesh_tree_first(const struct vr_mesh_tree *tree, const struct brick_ray *ray, struct vr_mesh_hit *hit)
{
    uint64_t todo[MAX_DEPTH + 1], left = 1;
    const struct ref *nearest = NULL;
    double weight[2] = {0};
    hit->t_mm = INFINITY;
    todo[0] = 0;
    while (left > 0) {
        const struct node *node = &tree->nodes[todo[--left]];
        if (enter_box(node, ray, hit->t_mm) == INFINITY)
            continue;
        for (uint64_t r = node->first; r < node->first + node->count; r++)
            if (meet(tree, &tree->refs[r], ray, &hit->t_mm, weight, hit->normal))
                nearest = &tree->refs[r];
        if (node->count)
            continue;
        const struct node *child = &tree->nodes[node->first];
        bool second_first = enter_box(child + 1, ray, hit->t_mm) < enter_box(child, ray, hit->t_mm);
        todo[left++] = node->first + !second_first;
        todo[left++] = node->first + second_first;
    }
    if (nearest)
        look(&tree->meshes[nearest->mesh], tree->meshes[nearest->mesh].mesh->triangle[nearest->triangle],
             weight, hit);
    return nearest;
}

/* shaders/shading.glsl, of a normal that is not 0 */
static void shade(const struct vr_mesh_view *view, const double direction[3], const struct vr_mesh_hit *hit,
                  double rgb[3])
{
    double largest = 0.0, n[3];
    for (int i = 0; i < 3; i++)
        largest = fmax(largest, fabs(hit->normal[i]));
    for (int i = 0; i < 3; i++)
        n[i] = hit->normal[i] / largest;
    const double facing = fmin(fabs(vr_dot(n, direction)) / sqrt(vr_dot(n, n)), 1.0);
    const double highlight = facing > 0.0 ? view->specular * pow(facing, view->shininess) : 0.0;
    for (int c = 0; c < 3; c++)
        rgb[c] = hit->rgb[c] * (view->ambient + view->diffuse * facing) + highlight;
}

int vr_mesh_view_begin(struct vr_mesh_view *view, const struct vr_scene *scene, const struct brick_grid *grid,
                       const struct brick_view *rays, struct brick_error *err)
{
    view->any = scene->mesh_count > 0;
    view->ambient = scene->ambient;
    view->diffuse = scene->diffuse;
    view->specular = scene->specular;
    view->shininess = scene->shininess;
    vr_scene_world_view(rays, grid, &view->world);
    if (!view->any)
        return BRICK_OK;
    if (view->tree && scene->meshes_number && scene->meshes_number == view->number) {
        view->tree->meshes = scene->meshes;
        return BRICK_OK;
    }
    vr_mesh_tree_destroy(&view->tree);
    view->number = scene->meshes_number;
    return vr_mesh_tree_create(&view->tree, scene->meshes, scene->mesh_count, err);
}

void vr_mesh_view_finish(struct vr_mesh_view *view)
{
    vr_mesh_tree_destroy(&view->tree);
    *view = (struct vr_mesh_view){0};
}

double vr_mesh_view_pixel(const struct vr_mesh_view *view, uint32_t column, uint32_t row, double rgb[3])
{
    struct brick_ray ray;
    struct vr_mesh_hit hit;
    if (!view->any)
        return INFINITY;
    brick_view_ray(&view->world, column, row, &ray);
    if (!vr_mesh_tree_first(view->tree, &ray, &hit))
        return INFINITY;
    shade(view, ray.direction, &hit, rgb);
    return hit.t_mm;
}
