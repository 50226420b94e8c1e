/* Why: OBJ through tinyobjloader, with doubles. It takes what is not a number for 0 and is silent; so lines
 * pass through a stream that looks at the numbers first. Materials, which name other files, are not read. */
#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <istream>
#include <map>
#include <new>
#include <streambuf>
#include <string>
#include <utility>
#include <vector>

#include "mesh_formats.h"

namespace
{

const size_t max_line_bytes = size_t(1) << 20;
const size_t chunk_bytes = size_t(1) << 16;

/* A file's lines, one after the other, until one is bad; then the file ends and result says why. */
class Lines : public std::streambuf
{
  public:
    Lines(const struct brick_io *io, struct brick_error *err) : io_(io), err_(err)
    {
        result = brick_io_size(io, &left_, err);
    }
    int result;
    uint64_t number = 0; /* of the line, from 1 */

  protected:
    int_type underflow() override
    {
        if (result != BRICK_OK || !next())
            return traits_type::eof();
        setg(&line_[0], &line_[0], &line_[0] + line_.size());
        return traits_type::to_int_type(line_[0]);
    }

  private:
    bool fail(const char *what)
    {
        result = brick_fail(err_, BRICK_ERR_FORMAT, "%s: line %llu: %s", io_->path,
                            static_cast<unsigned long long>(number), what);
        return false;
    }

    bool fill()
    {
        size_t n = left_ < chunk_bytes ? static_cast<size_t>(left_) : chunk_bytes;
        chunk_.resize(n);
        at_ = 0;
        if (n && (result = brick_io_read_at(io_, offset_, &chunk_[0], n, err_)) != BRICK_OK)
            return false;
        offset_ += n;
        left_ -= n;
        return n > 0;
    }

    bool next()
    {
        line_.clear();
        number++;
        while (line_.empty() || line_.back() != '\n') {
            if (at_ == chunk_.size() && !fill())
                break;
            size_t end = chunk_.find('\n', at_);
            size_t to = end == std::string::npos ? chunk_.size() : end + 1;
            line_.append(chunk_, at_, to - at_);
            at_ = to;
            if (line_.size() > max_line_bytes)
                return fail("too long");
        }
        if (result != BRICK_OK || line_.empty())
            return false;
        if (line_.find('\0') != std::string::npos)
            return fail("not text");
        return good();
    }

    /* "v" and "vn" have at least three numbers, and nothing that is none. */
    bool good()
    {
        const char *s = line_.c_str() + std::strspn(line_.c_str(), " \t");
        size_t word = std::strcspn(s, " \t\r\n"), numbers = 0;
        if (word == 0 || (std::strncmp(s, "v", word) != 0 && std::strncmp(s, "vn", word) != 0))
            return true;
        for (s += word;;) {
            s += std::strspn(s, " \t\r\n");
            if (!*s)
                break;
            char *end;
            double v = std::strtod(s, &end);
            bool decimal = std::strcspn(s, "xX") >= static_cast<size_t>(end - s);
            if (end == s || !std::strchr(" \t\r\n", *end) || !std::isfinite(v) || !decimal)
                return fail("not finite numbers");
            s = end;
            numbers++;
        }
        return numbers >= 3 || fail("fewer than three numbers");
    }

    const struct brick_io *io_;
    struct brick_error *err_;
    uint64_t offset_ = 0, left_ = 0;
    std::string chunk_, line_;
    size_t at_ = 0;
};

typedef std::pair<uint64_t, uint64_t> Corner; /* position; normal + 1, or 0 */

struct Reading {
    struct brick_mesh *mesh;
    const struct brick_io *io;
    struct brick_error *err;
    int result;
    std::vector<double> positions, normals;
    std::map<Corner, uint64_t> vertices; /* of the mesh */
};

void add_position(void *context, double x, double y, double z, double)
{
    std::vector<double> &all = static_cast<Reading *>(context)->positions;
    all.insert(all.end(), {x, y, z});
}

void add_normal(void *context, double x, double y, double z)
{
    std::vector<double> &all = static_cast<Reading *>(context)->normals;
    all.insert(all.end(), {x, y, z});
}

/* OBJ counts from 1, or back from the last with negative numbers. */
bool find(int index, const std::vector<double> &all, uint64_t *at)
{
    int64_t count = static_cast<int64_t>(all.size() / 3), i = index < 0 ? count + index : int64_t(index) - 1;
    *at = static_cast<uint64_t>(i);
    return index != 0 && i >= 0 && i < count;
}

int add_face(Reading *r, const tinyobj::index_t *indices, int count, struct brick_error *err)
{
    std::vector<uint64_t> corners;
    for (int k = 0; k < count; k++) {
        Corner corner(0, 0);
        if (!find(indices[k].vertex_index, r->positions, &corner.first))
            return brick_fail(err, BRICK_ERR_FORMAT, "face %llu has vertex %d of %zu",
                              static_cast<unsigned long long>(r->mesh->triangles), indices[k].vertex_index,
                              r->positions.size() / 3);
        if (indices[k].normal_index != 0) {
            if (!find(indices[k].normal_index, r->normals, &corner.second))
                return brick_fail(err, BRICK_ERR_FORMAT, "a face has normal %d of %zu",
                                  indices[k].normal_index, r->normals.size() / 3);
            corner.second++;
        }
        auto placed = r->vertices.insert(std::make_pair(corner, r->mesh->vertices));
        if (placed.second) {
            static const double none[3] = {0, 0, 0};
            int result = brick_mesh_add_vertex(r->mesh, &r->positions[3 * corner.first],
                                               corner.second ? &r->normals[3 * (corner.second - 1)] : none,
                                               nullptr, err);
            if (result)
                return result;
        }
        corners.push_back(placed.first->second);
    }
    return brick_mesh_add_polygon(r->mesh, corners.data(), corners.size(), err);
}

void take_face(void *context, tinyobj::index_t *indices, int count)
{
    Reading *r = static_cast<Reading *>(context);
    struct brick_error inner;
    if (r->result == BRICK_OK)
        r->result = fmt_mesh_place(r->io, add_face(r, indices, count, &inner), &inner, r->err);
}

int read(Reading *r)
{
    Lines lines(r->io, r->err);
    std::istream stream(&lines);
    tinyobj::callback_t callback;
    callback.vertex_cb = add_position;
    callback.normal_cb = add_normal;
    callback.index_cb = take_face;
    std::string warning, error;
    bool good = tinyobj::LoadObjWithCallback(stream, callback, r, nullptr, &warning, &error);
    if (lines.result != BRICK_OK)
        return lines.result;
    if (r->result == BRICK_OK && !good)
        return brick_fail(r->err, BRICK_ERR_FORMAT, "%s: not an OBJ file", r->io->path);
    return r->result;
}

} // namespace

int fmt_mesh_obj_read(struct brick_mesh *mesh, const struct brick_io *io, struct brick_error *err)
{
    try {
        Reading reading = {mesh, io, err, BRICK_OK, {}, {}, {}};
        return read(&reading);
    } catch (const std::bad_alloc &) {
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: no memory to read it", io->path);
    } catch (const std::exception &e) {
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: %s", io->path, e.what());
    }
}
