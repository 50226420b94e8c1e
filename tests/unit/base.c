/* Pool, I/O, errors. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <string.h>
#include <unistd.h>

#include <brick/checked.h>
#include <brick/io.h>
#include <brick/threads.h>

#include "../support/memory_source.h"

struct sums {
    uint64_t by_worker[64];
    unsigned threads;
};

static int add_item(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    (void)err;
    struct sums *s = context;
    assert_true(worker < s->threads);
    s->by_worker[worker] += item;
    return 0;
}

static void pool_runs_every_item_once(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 8; threads++) {
        struct brick_pool *pool;
        struct brick_error err;
        assert_int_equal(brick_pool_create(&pool, threads, &err), 0);
        assert_int_equal(brick_pool_threads(pool), threads);
        for (uint64_t n = 0; n < 300; n += 1 + n) {
            struct sums s = {.threads = threads};
            assert_int_equal(brick_pool_run(pool, n, add_item, &s, &err), 0);
            uint64_t sum = 0;
            for (unsigned t = 0; t < threads; t++)
                sum += s.by_worker[t];
            assert_int_equal(sum, n ? n * (n - 1) / 2 : 0);
        }
        brick_pool_destroy(&pool);
        assert_null(pool);
    }
}

static int fail_some(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    (void)context;
    (void)worker;
    if (item >= 17 && item % 3 == 2)
        return brick_fail(err, BRICK_ERR_FORMAT, "item %llu", (unsigned long long)item);
    return 0;
}

static void pool_reports_the_lowest_failure(void **state)
{
    (void)state;
    struct brick_pool *pool;
    struct brick_error err;
    assert_int_equal(brick_pool_create(&pool, 4, &err), 0);
    for (int i = 0; i < 500; i++) {
        assert_int_equal(brick_pool_run(pool, 100, fail_some, NULL, &err), BRICK_ERR_FORMAT);
        assert_string_equal(err.message, "item 17");
    }
    brick_pool_destroy(&pool);
}

static void io_reads_what_was_written(void **state)
{
    (void)state;
    struct brick_io io;
    struct brick_error err;
    char back[5] = {0};
    uint64_t bytes;
    const char *path = test_path("io");
    assert_int_equal(brick_io_create(&io, path, &err), 0);
    assert_int_equal(brick_io_write_at(&io, UINT64_C(5) << 32, "12345", 5, &err), 0); /* beyond 32 bits */
    assert_int_equal(brick_io_read_at(&io, (UINT64_C(5) << 32) + 1, back, 4, &err), 0);
    assert_string_equal(back, "2345");
    assert_int_equal(brick_io_size(&io, &bytes, &err), 0);
    assert_int_equal(bytes, (UINT64_C(5) << 32) + 5);
    assert_int_equal(brick_io_read_at(&io, bytes - 2, back, 4, &err), BRICK_ERR_FORMAT);
    assert_int_equal(brick_io_read_at(&io, UINT64_MAX - 2, back, 4, &err), BRICK_ERR_FORMAT);
    brick_io_close(&io);
    brick_io_close(&io);
    assert_int_equal(brick_io_create_scratch(&io, path, &err), 0);
    assert_int_not_equal(access(io.path, F_OK), 0); /* nameless at once */
    brick_io_close(&io);
    assert_int_equal(brick_io_open(&io, test_path("missing"), &err), BRICK_ERR_IO);
    assert_non_null(strstr(err.message, "missing"));
}

static void errors_are_one_line(void **state)
{
    (void)state;
    struct brick_error err;
    assert_int_equal(brick_fail(&err, BRICK_ERR_IO, "a\nb\tc %d", 5), BRICK_ERR_IO);
    assert_string_equal(err.message, "a?b?c 5");
    assert_int_equal(brick_fail(NULL, BRICK_ERR_IO, "x"), BRICK_ERR_IO);
}

static void checked_arithmetic(void **state)
{
    (void)state;
    uint64_t r = 7;
    assert_false(brick_mul3_u64(UINT64_C(1) << 30, UINT64_C(1) << 30, 16, &r));
    assert_int_equal(r, 7);
    assert_true(brick_mul3_u64(3, 5, 7, &r) && r == 105);
    assert_false(brick_add_u64(UINT64_MAX, 1, &r));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pool_runs_every_item_once), cmocka_unit_test(pool_reports_the_lowest_failure),
        cmocka_unit_test(io_reads_what_was_written), cmocka_unit_test(errors_are_one_line),
        cmocka_unit_test(checked_arithmetic),
    };
    return cmocka_run_group_tests_name("base", tests, NULL, NULL);
}
