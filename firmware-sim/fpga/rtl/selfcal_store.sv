// Fills frames with the matches of an AXI4-Stream, in three banks of a dual-clock memory: one is filled,
// one waits, one is read. A bank holds the frame as sent, 16 bytes a word, without the CRCs.
//
// A whole frame replaces the waiting one. The frame being read stays until the reader returns it.
module selfcal_store #(
    parameter int MATCHES = 254
) (
    input  logic         clk,
    input  logic         rst,

    // Matches. A beat with s_keep low carries no match, for a pair without matches. s_first may stay low.
    input  logic         s_valid,
    output logic         s_ready,
    input  logic         s_first,
    input  logic         s_last,
    input  logic         s_keep,
    // Steps of 2^-fraction_bits px, two's complement: negative ones are out of range.
    input  logic [24:0]  s_left_u,
    input  logic [24:0]  s_left_v,
    input  logic [24:0]  s_right_u,
    input  logic [24:0]  s_right_v,
    input  logic [15:0]  s_score,
    input  logic [3:0]   s_level,

    // Header. The timestamp is sampled with the first beat of a frame; the other fields are constant in a frame.
    input  logic [63:0]  timestamp,
    input  logic [15:0]  width,
    input  logic [15:0]  height,
    input  logic [15:0]  grid_step,
    input  logic [3:0]   fraction_bits,
    input  logic [7:0]   pyramid_ratio,

    // Counters, saturating: frames replaced unread, frames without their last beat, matches beyond the
    // buffer, matches out of range.
    output logic [15:0]  dropped,
    output logic [15:0]  unfinished,
    output logic [15:0]  overfull,
    output logic [15:0]  out_of_range,

    // Reader: a frame waits; the reader wants it; it has a bank until `want` falls.
    output logic         waiting,
    input  logic         want,
    output logic         granted,

    input  logic                          r_clk,
    input  logic [$clog2(MATCHES+2)-1:0]  r_word,
    output logic [127:0]                  r_data
);
    localparam int WORDS = MATCHES + 2;
    localparam int WORD_BITS = $clog2(WORDS);
    localparam int DEPTH = 3 * WORDS;
    localparam int ADDRESS_BITS = $clog2(DEPTH);

    function automatic logic [ADDRESS_BITS-1:0] base(input logic [1:0] of);
        case (of)
            2'd0:    base = '0;
            2'd1:    base = ADDRESS_BITS'(WORDS);
            default: base = ADDRESS_BITS'(2 * WORDS);
        endcase
    endfunction

    function automatic logic [15:0] up(input logic [15:0] n);
        up = &n ? n : n + 16'd1;
    endfunction

    // FILL takes matches. After the last beat TAIL writes word 1 of the header; then HEAD writes word 0 and changes
    // the banks.
    typedef enum logic [1:0] {FILL, TAIL, HEAD} state_t;
    state_t state;

    logic [1:0]           fill, ready_bank, bank;
    logic [15:0]          count;
    logic [31:0]          sequence_number;
    logic [63:0]          exposed;
    logic                 begun, more, gap;
    logic                 beat, restart, first, fits, in_range, write;
    logic [127:0]         word, tail_word, head_word, match_word;
    logic [WORD_BITS-1:0] index;

    assign s_ready  = state == FILL;
    assign beat     = s_valid && s_ready;
    assign restart  = s_first && begun;
    assign first    = s_first || !begun;
    assign fits     = first || count != 16'(MATCHES);
    assign in_range = !(s_left_u[24] || s_left_v[24] || s_right_u[24] || s_right_v[24]);

    assign tail_word  = {32'd0, height, width, exposed};
    assign head_word  = {grid_step, count, sequence_number, pyramid_ratio, 4'd0, fraction_bits,
                         6'd0, more, gap || waiting, 8'd1, 32'h464d4353};
    assign match_word = {12'd0, s_level, s_score, s_right_v[23:0], s_right_u[23:0],
                         s_left_v[23:0], s_left_u[23:0]};

    always_comb begin
        write = 1'b1;
        case (state)
            TAIL: begin
                word  = tail_word;
                index = WORD_BITS'(1);
            end
            HEAD: begin
                word  = head_word;
                index = '0;
            end
            default: begin
                word  = match_word;
                index = WORD_BITS'((first ? 16'd0 : count) + 16'd2);
                write = beat && s_keep && in_range && fits;
            end
        endcase
    end

    logic [127:0] memory [DEPTH];
    always_ff @(posedge clk)
        if (write) memory[base(fill) + ADDRESS_BITS'(index)] <= word;
    always_ff @(posedge r_clk)
        r_data <= memory[base(bank) + ADDRESS_BITS'(r_word)];

    always_ff @(posedge clk)
        if (rst) begin
            {state, fill, ready_bank, bank} <= {FILL, 2'd0, 2'd1, 2'd2};
            {begun, more, gap, waiting, granted} <= '0;
            {count, sequence_number} <= '0;
            {dropped, unfinished, overfull, out_of_range} <= '0;
        end else begin
            if (beat) begin
                begun <= 1'b1;
                if (first) begin
                    {count, more} <= '0;
                    exposed <= timestamp;
                end
                if (restart) begin
                    unfinished <= up(unfinished);
                    sequence_number <= sequence_number + 32'd1;
                    gap <= 1'b1;
                end
                if (write) count <= first ? 16'd1 : count + 16'd1;
                if (s_keep && !write) more <= 1'b1;
                if (s_keep && !in_range) out_of_range <= up(out_of_range);
                else if (s_keep && !fits) overfull <= up(overfull);
                if (s_last) state <= TAIL;
            end
            if (state == TAIL) state <= HEAD;
            if (state == HEAD) begin
                state <= FILL;
                {begun, gap, waiting} <= 3'b001;
                {fill, ready_bank} <= {ready_bank, fill};
                sequence_number <= sequence_number + 32'd1;
                if (waiting) dropped <= up(dropped);
            end else if (want && !granted && waiting) begin
                {bank, ready_bank} <= {ready_bank, bank};
                {granted, waiting} <= 2'b10;
            end
            if (!want) granted <= 1'b0;
        end

`ifdef FORMAL
    // Checked in simulation, and by induction in .ci/rtl: no write hits the bank being read, or leaves its bank.
    logic settled = 1'b0;
    always_ff @(posedge clk) begin
        if (rst) settled <= 1'b1;
        if (settled) begin
            assert (fill != ready_bank && fill != bank && ready_bank != bank);
            assert (fill != 2'd3 && ready_bank != 2'd3 && bank != 2'd3 && state != 2'd3);
            assert (32'(count) <= MATCHES && (!write || 32'(index) < WORDS));
        end
    end
`endif
endmodule
