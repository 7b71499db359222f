// Bytes to a UART: 8 data bits, no parity, one stop bit, DIVIDER cycles a bit.
module selfcal_uart #(
    parameter int DIVIDER = 100
) (
    input  logic        clk,
    input  logic        rst,
    input  logic        valid,
    output logic        ready,
    input  logic [7:0]  data,
    output logic        tx
);
    logic [8:0] shift;
    logic [3:0] bits;
    logic [$clog2(DIVIDER)-1:0] ticks;

    assign ready = bits == '0;

    always_ff @(posedge clk)
        if (rst) begin
            {bits, ticks} <= '0;
            {shift, tx} <= '1;
        end else if (ready) begin
            ticks <= '0;
            if (valid) begin
                {shift, tx} <= {1'b1, data, 1'b0};
                bits <= 4'd10;
            end
        end else if (32'(ticks) == DIVIDER - 1) begin
            ticks <= '0;
            bits <= bits - 4'd1;
            {shift, tx} <= {1'b1, shift};
        end else
            ticks <= ticks + 1'b1;
endmodule
