// Takes one bit into another clock domain, by two flip-flops, which are 0 after a reset.
module selfcal_sync (
    input  logic clk,
    input  logic rst,
    input  logic d,
    output logic q
);
    (* ASYNC_REG = "true" *) logic first;
    always_ff @(posedge clk)
        if (rst) {q, first} <= '0;
        else     {q, first} <= {first, d};
endmodule
